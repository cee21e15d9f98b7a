# Runs a command with kernels for the kind of processor that this one is: x86-64-v4 (AVX-512) or x86-64-v3 (AVX2 and FMA),
# both of which are in the image and round alike; on any other kernels are compiled when they are first needed.
# The first processors with AVX-512 slow their clock down for whole registers: they have no avx512_vbmi2, and take x86-64-v3.
has() {
  for flag in "$@"; do grep -qw "$flag" /proc/cpuinfo || return 1; done
}

if [ -z "${NUMBA_CPU_NAME:-}" ] && has avx2 fma bmi2; then
  NUMBA_CPU_NAME=x86-64-v3
  if has avx512f avx512bw avx512cd avx512dq avx512vl avx512_vbmi2; then NUMBA_CPU_NAME=x86-64-v4; fi
fi
# By itself LLVM uses half of the registers of x86-64-v4.
case "${NUMBA_CPU_NAME:-}" in
  "") ;;
  x86-64-v4) export NUMBA_CPU_NAME NUMBA_CPU_FEATURES=-prefer-256-bit ;;
  *) export NUMBA_CPU_NAME NUMBA_CPU_FEATURES= ;;
esac
exec "$@"
