// SPDX-License-Identifier: MIT
// Compiled alone: it has a macro of its own.
//
// glibc 2.35 gave `hypot` a second version, which differs in errno alone. A library that was linked
// statically calls the first version (--wrap), so that it also runs with an older glibc.
#ifdef QUADSPLAT_WRAPS_HYPOT
extern "C" {
double first_hypot(double x, double y);
__asm__(".symver first_hypot, hypot@GLIBC_2.2.5");
__attribute__((visibility("hidden"))) double __wrap_hypot(double x, double y) {
  return first_hypot(x, y);
}
}
#endif
