#!/usr/bin/env bash
# Man pages and completion, as the build made them from --help: whole, and at work in bash.
#   help.sh FOLDER PROGRAM...    FOLDER: build/release/apps/help
set -euo pipefail
folder="$1"
shift
fail() { echo "$1" >&2; exit 1; }
for name in "$@"; do
  page="$folder/piste-$name.1"
  for section in NAME SYNOPSIS DESCRIPTION ARGUMENTS OPTIONS "EXIT STATUS" "SEE ALSO"; do
    grep -qx ".SH $section" "$page" || fail "$page has no section $section"
  done
  # Every option that the program has.
  while read -r option; do
    grep -qF -- "${option//-/\\-}" "$page" || fail "$page has no $option"
  done < <(grep -oE '^  (-[a-z],)?--[a-z]+' "$folder/called/piste-$name.txt" | grep -oE -- '--[a-z]+')
  COMPREPLY=() COMP_WORDS=("piste-$name" --) COMP_CWORD=1
  # shellcheck disable=SC1090
  source "$folder/completion/piste-$name"
  "_piste_$name"
  [[ " ${COMPREPLY[*]} " == *" --output "* && " ${COMPREPLY[*]} " == *" --help "* ]] || fail "piste-$name completes ${COMPREPLY[*]}"
  complete -p "piste-$name" >/dev/null
done
cd "$(mktemp -d)"
touch run.yaml log.csv
COMP_WORDS=(piste-replay "") COMP_CWORD=1
_piste_replay
[[ "${COMPREPLY[*]}" == run.yaml ]] || fail "piste-replay completes ${COMPREPLY[*]}"
COMP_WORDS=(piste-inspect l)
_piste_inspect
[[ "${COMPREPLY[*]}" == log.csv ]] || fail "piste-inspect completes ${COMPREPLY[*]}"
rm -r "$PWD"
