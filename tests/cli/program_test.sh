#!/usr/bin/env bash
# The program itself: version, help, wrong usage.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

expect_ok --version
expect_says "$out" "stratus "
expect_silent "$err"

expect_ok --help
expect_says "$out" Example solve bake eval info verify convert export cost render
expect_silent "$err"

for command in solve bake eval info verify convert export cost render; do
    expect_ok "$command" --help
    expect_says "$out" Example "stratus $command"
done

expect_refused 2 COMMAND --
expect_refused 2 COMMAND "got 'nonsense'" -- nonsense
expect_refused 2 "got 'rendr'; did you mean 'render'?" -- rendr scene.toml
expect_refused 2 --nonsense -- --nonsense
expect_refused 2 TABLE -- eval
expect_refused 2 TABLE -- info
expect_refused 2 OUT -- convert in.h5
expect_refused 2 --nonsense -- info table.h5 --nonsense
finish
