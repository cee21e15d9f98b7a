# Starts a part of the system. Numba takes its cache only from a folder that it could write to, and the image is not to be
# written to: the compiled kernels, two megabytes for each kind of processor, are copied to /tmp first.
set -e
export XDG_CACHE_HOME=/tmp/cache MPLCONFIGDIR=/tmp/cache/matplotlib
mkdir -p "$XDG_CACHE_HOME"
cp -R /opt/cache/. "$XDG_CACHE_HOME"
exec sh /opt/processor.sh "$@"
