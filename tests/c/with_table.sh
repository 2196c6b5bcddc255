#!/usr/bin/env bash
# Bakes a small table, has `stratus eval` answer a query, and runs COMMAND TABLE.h5 ANSWER.csv.
#
#     with_table.sh STRATUS COMMAND...
set -eu
stratus=$1
shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$stratus" bake "$(dirname "$0")/../recipes/plain.toml" -o "$folder/table.h5" --accept 2>"$folder/log" ||
    { cat "$folder/log"; exit 1; }
printf '%s\n' 'mu_in,mu_out,azimuth_deg,optical_depth,albedo' '1,1,0,1,0.9' '0.5,0.8,60,1.5,0.95' '0.9,0.3,180,0.5,0.75' \
    '0.2,0.7,10,2,1' '0.6,0.6,90,1.2,0.8' >"$folder/query.csv"
"$stratus" eval "$folder/table.h5" --query "$folder/query.csv" -o "$folder/answer.csv"
"$@" "$folder/table.h5" "$folder/answer.csv"
