#!/bin/bash
# make.sh [PATTERN]: measures the reference results anew, those of the folders results/software-PATTERN (all if not given). Remove a folder first:
# what is there without its list is not measured over. docs/reference.md says what each folder shows.
set -euo pipefail
cd "$(dirname "$0")/.."
wanted=${1:-*}

tracebench() {
    # shellcheck disable=SC2254 # It is a pattern.
    case $out in $wanted) ;; *) return 0 ;; esac
    cargo run --release -- "$@" --out "results/software-$out"
}

out=pareto tracebench pareto --preset quick --scene room --rays primary,diffuse --points 4 --time-limit 2
out=need tracebench need --preset quick --size 256x128 --scene room --rays diffuse --time-limit 2
out=quick tracebench run --preset quick
out=improved tracebench run --tracer bvh-cpu,bvh-gpu,dirt,dirt:improved --preset quick --scene all --rays primary,specular,diffuse --time-limit 3
out=exact tracebench table exact --scene all,bunny.glb,kitchen.glb,sponza-dabrovic.glb --preset quick
case frames in $wanted) tests/frames.sh ;; esac
out=watertight tracebench run --tracer bvh-cpu,bvh-cpu@triangle=watertight --preset quick --scene all --rays primary,specular,diffuse --time-limit 3
planes=fragment-abuffer@thickness=0.001,voxel-abuffer
out=planes tracebench run --preset quick --frame-size 480x240 --scene all --rays primary,specular,diffuse --samples 1 \
    --tracer $planes,fragment-abuffer:improved,voxel-abuffer:improved
out=planes/finer tracebench run --preset quick --frame-size 764x382 --face-size 408 --scene all --rays primary,specular,diffuse --samples 1 --tracer $planes
for name in dirt fragment-abuffer voxel-abuffer quadtree lbvh-gpu; do
    out=ablation/$name tracebench table $name-ablation --preset quick --scene room --rays primary,diffuse --samples 5
done
out=stability tracebench stability
out=stability/improved tracebench stability --tracer bvh-cpu:improved,dirt:improved,fragment-abuffer:improved,voxel-abuffer:improved,quadtree:improved,lbvh-gpu:improved
out=bvh tracebench table bvh --preset quick --rays primary,diffuse
out=launch-settings tracebench table launch-settings --preset quick --scene room --rays diffuse
out=clock/alone tracebench doctor --clock --tracer bvh-gpu --preset smoke
out=clock/beside-another-job tracebench doctor --clock --tracer bvh-gpu --preset smoke --load 2
for name in bvh-cpu bvh-gpu; do
    out=clock/fresh-rays-$name tracebench doctor --clock --tracer $name --rays diffuse --fresh-rays 7 --samples 60
done

out=dirt/explain tracebench explain --preset smoke
out=dirt/tune tracebench sweep --choose footprint --tracer fragment-abuffer@buckets=4 --over thickness --scene room,hangar,candy --rays diffuse,specular --preset quick --size 128x64
for table in table1 figure7 figure8 figure9; do out=dirt/$table tracebench table dirt-$table --preset quick; done
out=dirt/table2 tracebench table dirt-table2 --preset quick --tuned results/software-dirt/tune
out=dirt/table3 tracebench table dirt-table3 --preset paper --samples 1
out=dirt/figure10 tracebench table dirt-figure10 --preset quick --only dirt.buckets=8,16,24
out=dirt/figure11 tracebench table dirt-figure11 --preset quick --samples 1
out=dirt/families tracebench table dirt-families --preset quick --size 128x64
out=dirt/text tracebench table dirt-text --preset quick --scene cloth,room
out=dirt/sweep tracebench sweep --tracer dirt --over tile_size,buckets,resolution,coverage,clip --scene room --rays diffuse --preset quick

small="--preset quick --size 128x64"
for table in table1 figure11; do out=vvp16/$table tracebench table vvp16-$table $small; done
out=vvp16/table2 tracebench table vvp16-table2 --preset paper --samples 1
out=vvp16/figure10 tracebench table vvp16-figure10 --preset quick
out=vvp16/figure12 tracebench table vvp16-figure12 $small --set rays.pixel_random_count=1
out=vvp16/views tracebench table vvp16-views $small --frame-size 256x128 --face-size 128
out=vvp16/views-of-peers tracebench table vvp16-views $small --frame-size 256x128 --face-size 128 --only fragment-abuffer.views=frame --samples 1
out=vvp16/tune tracebench sweep --choose footprint --tracer fragment-abuffer --over thickness --scene all --rays specular,diffuse $small
f=fragment-abuffer
out=vvp16/resolution tracebench sweep --tracer $f --over resolution=1/4,1/2,1,2 --set $f.thickness_in=pixels --set $f.thickness=2 --set $f.march=pixels \
    --scene room,candy,atrium --rays specular,diffuse $small

for table in table1 figure6 figure7 figure9 figure11 text; do out=hhz14/$table tracebench table hhz14-$table $small --face-size 512; done
out=hhz14/view-updates tracebench table view-updates --scene room --preset quick
v=voxel-abuffer
out=hhz14/solids tracebench run --tracer $v,$v@search=three-step,$v@search=one-step,$v:improved --scene solids --rays primary,specular,diffuse,refraction \
    $small --face-size 512 --samples 12
out=hhz14/sweep tracebench sweep --tracer $v --set $v.abuffer=1280 --set $v.grid=64 --grid abuffer=320,640,960,1280,2048,grid=32,64,128,256 \
    --scene solids,room,atrium --rays primary,diffuse,refraction $small --face-size 512 --samples 3

out=wkp15/table1 tracebench table wkp15-table1 --preset quick --size 64x32 --samples 12
for table in table2 table3 table4 table5 figure14 figure15 lightfield text; do out=wkp15/$table tracebench table wkp15-$table $small; done

for paper in dirt vvp16 hhz14 wkp15; do
    out=$paper/claims tracebench table $paper-claims --from $(ls -d results/software-$paper/{table,figure,text,families,views,lightfield}*/ 2> /dev/null)
done
case stability in $wanted) cargo run --release -- stability --expect harness/src/studies/stability/expected.csv \
    --from results/software-stability --from results/software-stability/improved ;; esac
