#!/usr/bin/env bash
# The library shows the functions that its headers declare, all of them and nothing else.
#
#     exports.sh LIBSTRATUS HEADER...
set -eu
library=$1
shift
declared=$(cat "$@" | sed -n 's/^[a-z].*[ *]\(stratus_[a-z_]*\)(.*/\1/p' | sort)
shown=$(nm --dynamic --defined-only "$library" | awk '{ print $3 }' | sort)
diff <(echo "$declared") <(echo "$shown")
