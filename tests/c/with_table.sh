#!/usr/bin/env bash
# Bakes a small table, has `stratus eval` answer a query, and runs COMMAND TABLE.h5 ANSWER.csv.
#
#     with_table.sh STRATUS COMMAND...
set -eu
stratus=$1
shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

cat >"$folder/recipe.toml" <<'TOML'
title = "Called from elsewhere"
phase_function = "henyey_greenstein:g=0.4"
tolerance = 1e-2
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.75, max = 1.0 }
[discretisation]
nodes = 12
modes = 9
mu_samples = 16
azimuth_samples = 8
optical_depth_samples_per_octave = 5
albedo_samples = 4
TOML
cat >"$folder/query.csv" <<'CSV'
mu_in,mu_out,azimuth_deg,optical_depth,albedo
1,1,0,1,0.9
0.5,0.8,60,1.5,0.95
0.9,0.3,180,0.5,0.75
0.2,0.7,10,2,1
0.6,0.6,90,1.2,0.8
CSV
"$stratus" bake "$folder/recipe.toml" -o "$folder/table.h5" 2>"$folder/log" || { cat "$folder/log"; exit 1; }
"$stratus" eval "$folder/table.h5" --query "$folder/query.csv" -o "$folder/answer.csv"
"$@" "$folder/table.h5" "$folder/answer.csv"
