#!/usr/bin/env bash
# Tests of scripts/commit_subject: commit_subject.sh SOURCE
set -euo pipefail
script="$1/scripts/commit_subject"
message="$(mktemp)"
trap 'rm -f "$message"' EXIT
fail() { echo "$1" >&2; exit 1; }
passes() { printf '%b' "$1" >"$message"; "$script" "$message" || fail "refused: $1"; }
refuses() {
  printf '%b' "$1" >"$message"
  said="$("$script" "$message" 2>&1)" && fail "let pass: $1"
  [[ "$said" == *"$2"* ]] || fail "says '$said' and not '$2' of: $1"
}
long="$(printf 'x%.0s' {1..72})"
umlauts="$(printf 'ä%.0s' {1..72})"  # characters are counted, not bytes
passes 'Filter: one subject'
passes "$long\n\nA body.\n"
passes "$umlauts\n"
passes "\n# a comment\nA subject\n# another\n\nA body.\n"
passes "fixup! $long\n"
passes "A subject\n\n# ------------------------ >8 ------------------------\ndiff --git a b\n"
refuses "x$long\n" 'has 73 characters'
refuses 'A subject\nthat goes on\n' 'second line is not blank'
refuses '# only a comment\n' 'is empty'
