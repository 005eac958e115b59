#!/bin/sh
# Runs every command in the README's ```sh blocks, in order, with build/ on the PATH; a command that fails fails the run.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
PATH=$PWD/build:$PATH
export PATH
script=$(mktemp)
trap 'rm -f "$script"' EXIT
awk '/^```sh$/ {on = 1; next} /^```/ {on = 0} on' README.md >"$script"
[ -s "$script" ] || { echo "the README shows no command"; exit 1; }
sh -eux "$script"
