#!/usr/bin/env bash
# A part in a wind tunnel, meshed by OpenFOAM: patches have the names of the part's faces, cells end at its sharp edges.
#
#     examples/openfoam/run.sh [RVACHEV [FOLDER]]
#
# RVACHEV is the program; the case is made in FOLDER, ./wind if not said. Needs OpenFOAM, tested with 1912 (Debian: apt install
# --no-install-recommends openfoam). Patches are part_bore and so on: the name of the surface in snappyHexMeshDict, and that of the face.
set -euo pipefail
rvachev=${1:-rvachev}
case=${2:-wind}
here=$(cd "$(dirname "$0")" && pwd)
for need in blockMesh snappyHexMesh checkMesh; do
    command -v "$need" >/dev/null || { echo "there is no $need: install OpenFOAM (Debian: apt install --no-install-recommends openfoam)" >&2; exit 1; }
done
# Debian's programs look for their settings here, and are told so by nobody.
if [ -z "${WM_PROJECT_DIR:-}" ] && [ -d /usr/share/openfoam/etc ]; then
    export WM_PROJECT_DIR=/usr/share/openfoam
fi

mkdir -p "$case/constant/triSurface"
cp -r "$here/system" "$case"
surface=$case/constant/triSurface
"$rvachev" mesh "$here/part.py" -q -o "$surface/part.stla" -o "$surface/part.emesh"
# OpenFOAM tells kinds of files by their endings, as it spells them.
mv "$surface/part.stla" "$surface/part.stl"
mv "$surface/part.emesh" "$surface/part.eMesh"
for program in blockMesh "snappyHexMesh -overwrite" "checkMesh -constant"; do
    log=$case/log.${program%% *}
    $program -case "$case" >"$log" 2>&1 || { tail -n 40 "$log" >&2; echo "${program%% *} failed: $log" >&2; exit 1; }
done
# checkMesh finds faults and succeeds all the same.
grep -q "^Mesh OK" "$case/log.checkMesh" || { tail -n 40 "$case/log.checkMesh" >&2; echo "checkMesh found faults" >&2; exit 1; }
sed -n 's/^ \{1,\}\(cells:\)/\1/p; s/.*\(Total volume = [0-9.]*\)\..*/\1/p; /^Mesh OK/p' "$case/log.checkMesh"
