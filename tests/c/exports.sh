#!/usr/bin/env bash
# The library shows the functions that its header declares, all of them and nothing else.
#
#     exports.sh LIBSTRATUS HEADER
set -eu
declared=$(sed -n 's/^[a-z].*[ *]\(stratus_[a-z_]*\)(.*/\1/p' "$2" | sort)
shown=$(nm --dynamic --defined-only "$1" | awk '{ print $3 }' | sort)
diff <(echo "$declared") <(echo "$shown")
