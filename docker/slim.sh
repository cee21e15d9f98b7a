# Leaves in an environment what runs: no tests and what helps others to test, no installers, no sources, headers and
# stubs, and nothing of Dask's pages, which are switched off. Then times of sources are whole seconds, as layers of images
# keep them: Numba and Python compare them with those that their caches were made from.
set -e
environment=$1
"$environment/bin/pip" uninstall --quiet --yes hatchling pathspec pluggy trove-classifiers
"$environment/bin/python" -m pip uninstall --quiet --yes pip setuptools
find "$environment/lib" -type d -path '*/site-packages/*' \
  \( -name tests -o -path '*/sqlalchemy/testing' -o -name sample_data -o -path '*/distributed/http/static' \) -prune -exec rm -rf {} +
find "$environment/lib" -path '*/site-packages/*' \( -name '*.c' -o -name '*.cpp' -o -name '*.pyx' -o -name '*.pxd' \
  -o -name '*.h' -o -name '*.hpp' -o -name '*.pyi' -o -name '*.a' \) -delete
find "$environment" -exec touch --no-dereference --date=@0 {} +
"$environment/bin/python" -m compileall -q -j 0 "$environment/lib"
