// SPDX-License-Identifier: MIT
//
// Switches of attempts that are being measured. They go when the attempts are decided.
#pragma once

#ifndef QS_TRY_ONE_WARP  // blend(): blocks of one warp, half a tile each
#define QS_TRY_ONE_WARP 0
#endif
#ifndef QS_TRY_RING  // slots of a ring, a multiple of 4
#define QS_TRY_RING 48
#endif
#ifndef QS_TRY_WARPS  // warps of blend() per multiprocessor, at most; 0: as many as fit
#define QS_TRY_WARPS 0
#endif
#ifndef QS_TRY_RESERVE  // project: a thread's reservations are under way at the same time
#define QS_TRY_RESERVE 0
#endif
#ifndef QS_TRY_EARLY_COLOR  // `color` begins beside append_large
#define QS_TRY_EARLY_COLOR 0
#endif
#ifndef QS_TRY_PLACE  // list: fewer dependent accesses to global memory
#define QS_TRY_PLACE 0
#endif
#ifndef QS_TRY_STOPS  // far views: stopping pixels are found once per list
#define QS_TRY_STOPS 0
#endif
#ifndef QS_TRY_JOIN_BLOCKS
#define QS_TRY_JOIN_BLOCKS 256
#endif
#ifndef QS_TRY_SEGMENT_BLOCKS
#define QS_TRY_SEGMENT_BLOCKS 1024
#endif
#ifndef QS_TRY_FEW_PIXELS
#define QS_TRY_FEW_PIXELS 4
#endif
#ifndef QS_TRY_LINES  // project: the lanes of a warp share the lines of its walks
#define QS_TRY_LINES 0
#endif
#ifndef QS_TRY_KEPT_LINES  // project: lines of a walk in shared memory
#define QS_TRY_KEPT_LINES 12
#endif
#ifndef QS_TRY_MATCH  // sort: one instruction finds equal digits
#define QS_TRY_MATCH 0
#endif
#ifndef QS_TRY_MACRO  // project: a Gaussian that meets more macro-tiles is large
#define QS_TRY_MACRO 0
#endif
#ifndef QS_TRY_HEAVY  // Gaussians of a macro-tile that 1,024 threads sort
#define QS_TRY_HEAVY 3072
#endif
#ifndef QS_TRY_PROJECT_BLOCKS  // per multiprocessor
#define QS_TRY_PROJECT_BLOCKS 5
#endif
#ifndef QS_TRY_FILL  // fill_slices: reservations under way at the same time
#define QS_TRY_FILL 0
#endif
#ifndef QS_TRY_LIST_BLOCKS  // blocks per multiprocessor that list usual macro-tiles
#define QS_TRY_LIST_BLOCKS 6
#endif
#ifndef QS_TRY_SEGMENT  // samples of a segment
#define QS_TRY_SEGMENT 64
#endif
#ifndef QS_TRY_UNCUT  // pairs of a list in an ordinary picture that is not cut
#define QS_TRY_UNCUT 4096
#endif
#ifndef QS_TRY_COPY  // blend: splats are copied to shared memory ahead, four lanes a splat
#define QS_TRY_COPY 0
#endif
