#!/usr/bin/env bash
# What a frame costs that rebuilds its structure and traces one diffuse ray a pixel at 512x256: the improved form of DIRT, with tiles as they are,
# with half and with a quarter as many along an edge, beside every hierarchy at its best and at its quickest build. All scenes in one run,
# times by the host's clock until work is done. A table goes to results/software-frames/frames.csv, or to the file that OUT names, and the
# record that it is made of to the folder frames-records beside it.
#     tests/frames.sh
. "$(dirname "$0")/study.sh" software-frames/frames.csv
makes_records

"$program" run --preset quick --scene "${SCENES:-all}" --rays diffuse --size 512x256 --time-limit 2 --out "$scratch/run" \
    --tracer bvh-cpu,bvh-cpu@build=fastest,bvh-gpu,bvh-gpu@build=fastest,lbvh-gpu:improved,dirt:improved,dirt:improved@face_tiles=16,dirt:improved@face_tiles=8 > /dev/null
# A frame has the steady build, as a whole by the host's clock, and the trace: of the host's tracers by the same clock, of the others from submission until
# done. `over_fastest` is how many times the frame of the fastest hierarchy a frame takes, `build_over_bvh_cpu` (`first_build_over_bvh_cpu`) how many times
# as long as `bvh-cpu` it builds in the steady (first) build.
jq -r '
    def ms: .submit_to_done_median_ms // .median_ms;
    .commit as $commit
    | [.rows[] | {scene: .scene.name, tracer: .tracer.name, preset: .tracer.preset, parameters: .tracer.parameters,
        build: .build.steady.median_ms, first: .build.first.median_ms, trace: (.traces[0] | ms), right: .traces[0].judgement.agreement.tight}]
    | group_by(.scene)[]
    | (map(select(.tracer != "dirt") | .build + .trace) | min) as $fastest
    | (map(select(.tracer == "bvh-cpu" and .parameters.build != "fastest")) | first) as $cpu
    | .[] | [.scene, .tracer, .preset, (if .tracer == "dirt" then .parameters.face_tiles else .parameters.build end), .build, .trace, .build + .trace,
        (.build + .trace) / $fastest, .build / $cpu.build, .right, .first, .first / $cpu.first, $commit]
    | @csv' "$scratch/run/run.json" | tr -d '"' > "$scratch/frames.csv"
keep "$scratch/run" .
{ echo 'scene,tracer,preset,point,build_ms,trace_ms,frame_ms,over_fastest,build_over_bvh_cpu,tight_share,first_build_ms,first_build_over_bvh_cpu,commit'; cat "$scratch/frames.csv"; } > "$scratch/table.csv"
finish "$scratch/table.csv"
