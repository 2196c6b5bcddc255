"""The program itself: version, help, wrong usage."""

from expect import *

commands = "solve", "bake", "eval", "info", "verify", "convert", "export", "cost", "render"
expect_ok("--version", out="stratus ", err="")
expect_ok("--help", out=" | ".join(["Example", *commands]), err="")
for command in commands:
    expect_ok(command + " --help", out="Example | stratus " + command)
expect_refused(
    " => COMMAND",
    "nonsense => COMMAND | got 'nonsense'",
    "rendr scene.toml => got 'rendr'; did you mean 'render'?",
    "--nonsense => --nonsense",
    "eval => TABLE",
    "info => TABLE",
    "convert in.h5 => OUT",
    "info table.h5 --nonsense => --nonsense")
finish()
