#!/usr/bin/env bash
# Writes tests/malformed/verdicts.tsv anew: the errors of the Khronos glTF validator for every model of the assets folder.
#   tests/malformed/validate.sh NODE_MODULES     a folder into which `npm install gltf-validator` was run, outside of this tree
set -euo pipefail
[[ $# -eq 1 && -d $1/gltf-validator && -d ${PARHELION_ASSETS:-} ]] || { sed -n '2,3s/^# //p' "${BASH_SOURCE[0]}" >&2; echo "needs PARHELION_ASSETS" >&2; exit 2; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)
NODE_PATH=$1 node "$here/validate.js" "$PARHELION_ASSETS" >"$here/verdicts.tsv.new"
mv "$here/verdicts.tsv.new" "$here/verdicts.tsv"
