#!/bin/sh
# The library holds no mutable file-scope state, its names begin with saltus_, and the shared library exports what the
# public headers declare and nothing else.
# Arguments: the static library, the shared one, the folder of the public headers.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
symbols=$(nm "$1" | awk 'NF == 3 {print $2, $3}' | grep -v -E ' (__asan|__ubsan|__odr_asan|\.L|_GLOBAL__|asan\.|DW\.ref|\.str|_sub_[ID])' || true)
# B/b: zeroed data, D: data, C: common. Constant tables with pointers live in .data.rel.ro (nm: d), which is read-only
# after loading; they are told apart by their section below.
mutable=$(printf '%s\n' "$symbols" | awk '$1 == "B" || $1 == "b" || $1 == "C" {print $2}')
data=$(objdump -t "$1" 2>/dev/null | awk '$NF !~ /^\./ && ($0 ~ / \.data[ \t]/ || $0 ~ / \.bss[ \t]/ || $0 ~ / \.tdata[ \t]/) {print $NF}' |
    grep -v -E '^(__asan|__ubsan|__odr_asan|_GLOBAL__|\*\.L|\.L|\*)' || true)
foreign=$(printf '%s\n' "$symbols" | awk '$1 ~ /^[TDBRC]$/ && $2 !~ /^saltus_/ {print $2}')
if [ -n "$mutable$foreign" ]; then
    echo "mutable: $mutable"
    echo "exported without the prefix: $foreign"
    exit 1
fi
if [ -n "$data" ] && [ "${SALTUS_SANITIZED:-0}" = 0 ]; then
    echo "writable data: $data"
    exit 1
fi
exported=$(nm -D --defined-only "$2" | awk '{print $NF}' | grep -v ___sancov_ | sort) # but the fuzzers' tables
declared=$(grep -ho 'saltus_[a-z0-9_]*(' "$3"/*.h | tr -d '(' | sort -u)
different=$(printf '%s\n%s\n' "$exported" "$declared" | sort | uniq -u)
if [ -n "$different" ]; then
    echo "exported but not declared, or declared but not exported: $different"
    exit 1
fi
echo "no mutable file-scope state, $(printf '%s\n' "$exported" | wc -l) symbols exported"
