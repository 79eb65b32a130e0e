# SPDX-License-Identifier: MIT
# Finds nvcc and sets QUADSPLAT_HAVE_CUDA. Without nvcc everything but the CUDA backend builds.
set(QUADSPLAT_HAVE_CUDA OFF)
if(NOT QUADSPLAT_CUDA STREQUAL "OFF")
  include(CheckLanguage)
  check_language(CUDA)  # PATH, CUDACXX, then /usr/local/cuda
  if(CMAKE_CUDA_COMPILER)
    if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)  # before enable_language
      set(CMAKE_CUDA_ARCHITECTURES "75-real;80-real;86-real;89-real;90-real;90-virtual"
          CACHE STRING "CUDA architectures")
    endif()
    enable_language(CUDA)
    # CMake before 3.26 does not know the C++20 flag of nvcc 12 and later.
    if(CMAKE_CUDA_COMPILER_VERSION VERSION_GREATER_EQUAL 12.0 AND NOT CMAKE_CUDA20_STANDARD_COMPILE_OPTION)
      set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION "-std=c++20")
      set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION "-std=c++20")
    endif()
    set(CMAKE_CUDA_STANDARD 20)
    set(CMAKE_CUDA_STANDARD_REQUIRED ON)
    set(CMAKE_CUDA_EXTENSIONS OFF)
    find_package(CUDAToolkit REQUIRED)
    set(QUADSPLAT_HAVE_CUDA ON)
  elseif(QUADSPLAT_CUDA STREQUAL "ON")
    message(FATAL_ERROR "QUADSPLAT_CUDA is ON, but no CUDA compiler (nvcc) was found")
  endif()
endif()
