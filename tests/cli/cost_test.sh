#!/usr/bin/env bash
# stratus cost: its CSV and its figure, what it says, and every refusal.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

cat >tiny.toml <<'RECIPE'
phase_function = "isotropic"
tolerance = 0.1
optical_depth = { min = 1.0, max = 1.0 }
albedo = { min = 0.9, max = 0.9 }
sides = ["reflection"]
RECIPE
header=kind,varied,tolerance,nodes,modes,mu_samples,azimuth_samples
header+=,optical_depth_samples_per_octave,albedo_samples
header+=,mixture_samples,g_samples,radius_samples,wavelength_samples,variance_samples
header+=,error_median,error_99_9,error_largest,solve_seconds
header+=,bake_seconds,bytes,lookup_ns,on_frontier,times_frontier

# --- answers

expect_ok cost tiny.toml -o cost.csv --svg cost.svg --seconds 1000
expect_silent "$out"
expect_says "$err" "converged solution: " " nodes; with half of them it is " "tolerance 0.1: solver error " \
    "tolerance 0.1: table error " "tolerance 0.1: packed error " " us a lookup" "times the time of the cheapest" \
    "times the bytes of the cheapest"
[ "$(find . -name '*.csv' -o -name '*.svg' -o -name '.*.*' | wc -l)" -eq 2 ] || fail "only the two answers may be made"
cp cost.csv "$out"
expect_header "$header"
own='f["kind"] ~ /table|packed/ && f["bytes"] > 0 && f["lookup_ns"] > 0 && f["solve_seconds"] == ""'
own+=' || f["kind"] == "solver" && f["solve_seconds"] > 0 && f["bytes"] == ""'
expect_rows "$(($(wc -l <cost.csv) - 1))" "$own"
for row in '^solver,tolerance,0.1,' '^solver,nodes and modes,,' '^table,tolerance,0.1,' '^table,mu_samples,,' \
    '^packed,tolerance,0.1,'; do
    grep -q "$row" cost.csv || fail "the answer needs a row $row"
done
if command -v python3 >/dev/null; then
    python3 -c 'import sys, xml.dom.minidom; xml.dom.minidom.parse(sys.argv[1])' cost.svg 2>"$logs/xml" ||
        fail "the figure must be XML: $(cat "$logs/xml")"
fi
grep -q '<svg ' cost.svg || fail "the figure must be an SVG"

# a family: rows of members along its axis
{ cat tiny.toml; echo 'second_phase_function = "rayleigh"'; } >family.toml
expect_ok cost family.toml -o family.csv --svg family.svg --seconds 1000
expect_says "$err" "converged solution: " "tolerance 0.1: table error "
awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) c[$i] = i }
    $c["varied"] == "mixture_samples" && $c["mixture_samples"] > 1 && $c["bytes"] > 0 && $c["bake_seconds"] > 0 { found = 1 }
    END { exit !found }' family.csv || fail "the answer needs a row that varies the members"
grep -q '<svg ' family.svg || fail "the figure must be an SVG"
rm family.toml family.csv family.svg

# quiet is silent, - is stdout, an older figure is replaced
echo older >cost.svg
expect_ok cost tiny.toml -o - --svg cost.svg --seconds 1 --threads 1 --quiet
expect_silent "$err"
expect_header "$header"
grep -q '<svg ' cost.svg || fail "the older figure must be replaced"

expect_ok cost --help
expect_says "$out" "stratus cost tables/saturn_rings.toml -o cost.csv --svg cost.svg"
for column in ${header//,/ }; do expect_says "$out" "  $column: "; done

# --- interruption: no half file, nothing left over

echo older >older.csv
cp older.csv older.svg
before=$(snapshot)
sed 's/isotropic/henyey_greenstein:g=0.9/; s/= 0.1$/= 1e-5/' tiny.toml >"$logs/long.toml"
timeout --foreground -s INT 0.4 "$stratus" cost "$logs/long.toml" -o older.csv --svg older.svg >"$out" 2>"$err"
[ $? -eq 124 ] || fail "it must be interrupted by SIGINT"
[ "$before" = "$(snapshot)" ] || fail "files differ after SIGINT"

# --- refusals

for value in 0 -1 nan x ''; do
    expect_refused 2 --seconds "above 0" "got ${value:-nothing}" -- cost tiny.toml --seconds "$value"
done
for value in -1 1025 1.5 x ''; do
    expect_refused 2 --threads "in [0, 1024]" "got ${value:-nothing}" -- cost tiny.toml --threads "$value"
done
expect_refused 2 --svg .svg "got cost.png" -- cost tiny.toml --svg cost.png
expect_refused 2 --svg file "got nothing" -- cost tiny.toml --svg ''
expect_refused 2 --output file "got nothing" -- cost tiny.toml -o ''
mkdir folder.svg
expect_refused 2 --svg file "got the folder folder.svg" -- cost tiny.toml --svg folder.svg
expect_refused 2 --output file "got the folder folder.svg" -- cost tiny.toml -o folder.svg
expect_refused 1 absent/new.csv "no folder absent" -- cost tiny.toml -o absent/new.csv
expect_refused 1 absent/new.svg "no folder absent" -- cost tiny.toml --svg absent/new.svg
expect_refused 2 tiny.toml another -- cost tiny.toml -o tiny.toml
expect_refused 2 older.svg another -- cost tiny.toml -o older.svg --svg older.svg
expect_refused 2 RECIPE required -- cost
expect_refused 1 absent.toml -- cost absent.toml -o older.csv
expect_refused 1 "absent.toml: cannot be read" -- cost absent.toml -o /dev/stdout  # which takes what comes
expect_refused 2 extra -- cost tiny.toml extra
sed 's/0.1$/0.2/' tiny.toml >bad.toml
expect_refused 2 tolerance "[1e-6, 0.1]" "got 0.2" -- cost bad.toml -o older.csv --svg older.svg

# a figure that no disk takes; the few rows have been written then
through "$size_limited" expect_refused 1 older.svg: "too large" -- cost tiny.toml --seconds 1e-3 --quiet -o "$logs/cost.csv" \
    --svg older.svg
finish
