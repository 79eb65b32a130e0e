# shellcheck shell=bash
# Functions shared by several scripts, which source this file: root, say, fail, gpu_present, find_nvcc, nvcc_major,
# gpu_architectures, debian_mirror, write_webp.

# shellcheck disable=SC2034  # used by the scripts that source this
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s: %s\n' "${0##*/}" "$*" >&2; }
fail() { say "$@"; exit 1; }

# True if this machine has an NVIDIA GPU: its device files, its driver, or a display controller on the PCI bus.
gpu_present() {
  [[ -e /dev/nvidiactl || -e /proc/driver/nvidia/version ]] && return 0
  local device class vendor
  for device in /sys/bus/pci/devices/*; do
    { read -r vendor < "$device/vendor" && read -r class < "$device/class"; } 2>/dev/null || continue
    [[ $vendor == 0x10de && $class == 0x03* ]] && return 0
  done
  return 1
}

# Prints the path of the CUDA compiler; fails if none is installed.
find_nvcc() {
  local nvcc
  for nvcc in "${CUDACXX:-}" "$(command -v nvcc)" "${CUDA_PATH:-}/bin/nvcc" /usr/local/cuda/bin/nvcc; do
    [[ -x $nvcc ]] && echo "$nvcc" && return 0
  done
  return 1
}

# Prints the major version of the CUDA compiler, or 0 if none is installed.
nvcc_major() {
  local nvcc major=
  nvcc=$(find_nvcc) && major=$("$nvcc" --version 2>/dev/null | sed -n 's/.*release \([0-9]*\)\..*/\1/p')
  echo "${major:-0}"
}

# gpu_architectures NVCC: CMake's list of architectures for every GPU since compute capability 7.5 that the compiler
# knows, and PTX for GPUs after them. GPUs of 8.9 run the code for 8.6; code of their own would add a megabyte.
gpu_architectures() {
  local real arch=''
  for real in $("$1" --list-gpu-code | sed -n 's/^sm_//p'); do
    case $real in 75 | 80 | 86 | 90 | 100 | 120) arch+="$real-real;" ;; esac
  done
  echo "${arch}90-virtual"
}

# Prints the address from which debootstrap takes packages: MIRROR, or the mirror in apt's sources for this machine's
# release.
debian_mirror() {
  local here mirror=${MIRROR:-}
  here=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
  # shellcheck disable=SC2016  # apt-get replaces these names
  [[ -n $mirror ]] || mirror=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE)' 'Created-By: Packages' |
                               awk -v release="$here" '$2 == release { print $1; exit }')
  [[ -n $mirror ]] || fail "apt's sources name no mirror for $here: set MIRROR"
  echo "$mirror"
}

# write_webp FROM TO [OPTIONS...]: a picture of the documentation, a third of a JPEG's size, with ImageMagick's convert.
# Without the deblocking filter the edges of tiles in heat maps stay sharp.
write_webp() {
  convert "$1" -strip -quality 88 -define webp:method=6 -define webp:use-sharp-yuv=1 -define webp:filter-strength=0 "${@:3}" "$2"
}
