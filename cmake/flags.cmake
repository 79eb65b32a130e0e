# SPDX-License-Identifier: MIT
# quadsplat_flags: warnings, and no contraction of a*b+c, so that all backends decide equally to the last bit.
# -fno-trapping-math lets GCC vectorise float comparisons; it changes no value.
add_library(quadsplat_flags INTERFACE)
target_compile_options(quadsplat_flags INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic -Wshadow -Wconversion -ffp-contract=off -fno-trapping-math -fno-math-errno>
  $<$<COMPILE_LANGUAGE:CUDA>:-Xcompiler=-Wall,-Wextra,-ffp-contract=off -diag-suppress=20012
                             --expt-relaxed-constexpr --extended-lambda>)
# GCC 12 does not recognise system headers in a precompiled header, so it reports false warnings about std::string.
if(QUADSPLAT_PCH)
  target_compile_options(quadsplat_flags INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-array-bounds -Wno-restrict
    -Wno-stringop-overflow -Wno-stringop-overread>)
endif()
# GCC 13 and later suspect every function that returns a reference and takes a temporary object. GCC 14 suspects the
# destructors of std::optional, although they ask has_value() first.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  target_compile_options(quadsplat_flags INTERFACE
    $<$<COMPILE_LANGUAGE:CXX>:-Wno-dangling-reference -Wno-maybe-uninitialized>)
endif()
# GCC warns that ThreadSanitizer does not know the fences of Boost.Asio; the server uses them on one thread.
if(QUADSPLAT_SANITIZE MATCHES thread)
  target_compile_options(quadsplat_flags INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-tsan>)
endif()
if(QUADSPLAT_WERROR)
  target_compile_options(quadsplat_flags INTERFACE
    $<$<COMPILE_LANGUAGE:CXX>:-Werror> $<$<COMPILE_LANGUAGE:CUDA>:-Werror=all-warnings>)
endif()
if(QUADSPLAT_SANITIZE)
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${QUADSPLAT_SANITIZE}>
                      $<$<COMPILE_LANGUAGE:CXX>:-fno-omit-frame-pointer>
                      $<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize-recover=all>)
  # `checked` compiles a quarter faster without these checks of pointers. AddressSanitizer stops at null pointers too;
  # misaligned ones are found by `asan`, which also has all instruction sets.
  if(QUADSPLAT_PLAIN_FOLDER)
    add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize=null,alignment,vptr>)
    add_compile_definitions(QUADSPLAT_FEW_INSTRUCTION_SETS)
  endif()
  add_link_options(-fsanitize=${QUADSPLAT_SANITIZE})
endif()
# Instruments all libraries for libFuzzer; only the fuzz program links the fuzzer itself.
if(QUADSPLAT_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES Clang)
    message(FATAL_ERROR "QUADSPLAT_FUZZ needs clang: -DCMAKE_CXX_COMPILER=clang++")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
