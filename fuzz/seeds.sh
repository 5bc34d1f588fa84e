#!/usr/bin/env bash
# Fills fuzz/corpus with what the readers read: samples of data/, and what the command makes of them. The command is built, unless
# RVACHEV names one.
set -euo pipefail
cd "$(dirname "$0")/.."
for target in part vm csg levelset step points plan piece stl obj ply off msh inp bdf medit su2 vtk threemf; do
    mkdir -p "fuzz/corpus/$target"
done
# Larger files are passed over by the targets.
find data -name '*.py' -size -64k -exec cp {} fuzz/corpus/part \;
find data -name '*.step' -size -64k -exec cp {} fuzz/corpus/step \;
cp data/nut.csg fuzz/corpus/csg
if [ -z "${RVACHEV:-}" ]; then
    cargo build --release --quiet --bin rvachev
fi
rvachev=$(realpath "${RVACHEV:-${CARGO_TARGET_DIR:-target}/release/rvachev}")
"$rvachev" convert -q data/cube_with_holes.py -o fuzz/corpus/vm/cube.vm
"$rvachev" convert -q data/cube_with_holes.py -o fuzz/corpus/levelset/cube.3mf
unzip -p fuzz/corpus/levelset/cube.3mf 3D/3dmodel.model >fuzz/corpus/levelset/cube.model
printf 'x,y,z\n0,0,0\n0.5,0.25,1e-3\n' >fuzz/corpus/points/names.csv
printf '# no names\n0 0 0\n1\t2 3\n' >fuzz/corpus/points/blanks.txt
mesh() { "$rvachev" heal -q data/soups/bored_block.off -o "fuzz/corpus/$1/block.$2"; }
for ending in stl obj ply off msh inp bdf su2; do mesh "$ending" "$ending"; done
mesh stl stla
mesh medit mesh
mesh vtk vtu
mesh vtk vtp
mesh threemf 3mf
# The plan of one brick that the target for pieces holds, and its piece.
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
printf 'part(sphere(1))\n' >"$folder/ball.py"
(cd "$folder" && "$rvachev" plan -q ball.py --size 0.5 --bricks 1x1x1 -o plan && "$rvachev" brick -q plan --round 1)
cp "$folder/plan/plan.json" fuzz/corpus/plan
cp "$folder"/plan/round1/*.piece fuzz/corpus/piece
# Lists of names, which the command writes beside meshes, are no meshes.
find fuzz/corpus -name "*.names.json" -delete
