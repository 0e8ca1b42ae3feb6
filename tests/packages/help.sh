#!/usr/bin/env bash
# Man pages and completion, as the build made them from --help: whole, and at work in bash, and in zsh and fish where they are.
#   help.sh FOLDER PROGRAM...    FOLDER: build/release/apps/help
set -euo pipefail
here="$(dirname "$(realpath "${BASH_SOURCE[0]}")")"
folder="$1"
shift
fail() { echo "$1" >&2; exit 1; }
for name in "$@"; do
  page="$folder/piste-$name.1"
  for section in NAME SYNOPSIS DESCRIPTION ARGUMENTS OPTIONS "EXIT STATUS" "SEE ALSO"; do
    grep -qx ".SH $section" "$page" || fail "$page has no section $section"
  done
  # What whatis shows: a verb first, a whole sentence without its full stop, short enough for a line of 80 characters.
  line="$(sed -n '/^.SH NAME$/{n;p;}' "$page")"
  [[ "$line" =~ ^"piste\-$name \- "([a-z]+s\ [^:;]*[A-Za-z])$ ]] || fail "$page: '$line' does not say what the program does"
  ((${#BASH_REMATCH[1]} <= 57)) || fail "$page: '$line' is too long for a line of whatis"
  grep -q "^${BASH_REMATCH[1]^}\(\. \|$\)" "$folder/called/piste-$name.txt" || fail "$page: '$line' is no whole sentence of --help"
  # Every option that the program has.
  while read -r option; do
    grep -qF -- "${option//-/\\-}" "$page" || fail "$page has no $option"
    for completion in "bash/piste-$name" "zsh/_piste-$name"; do
      grep -qwF -- "$option" "$folder/$completion" || fail "$folder/$completion has no $option"
    done
    grep -q -- " -l ${option#--} " "$folder/fish/piste-$name.fish" || fail "$folder/fish/piste-$name.fish has no $option"
  done < <(grep -oE '^  (-[a-z],)?--[a-z-]+' "$folder/called/piste-$name.txt" | grep -oE -- '--[a-z-]+')
  COMPREPLY=() COMP_WORDS=("piste-$name" --) COMP_CWORD=1
  # shellcheck disable=SC1090
  source "$folder/bash/piste-$name"
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
COMP_WORDS=(piste-allan --sensor l) COMP_CWORD=2
_piste_allan
[[ "${COMPREPLY[*]}" == log.csv ]] || fail "--sensor completes ${COMPREPLY[*]}"
if command -v zsh >/dev/null; then
  zsh -n "$folder"/zsh/_piste-*
  for line in "piste-replay r:piste-replay run.yaml" "piste-replay --ou:piste-replay --output" "piste-inspect l:piste-inspect log.csv"; do
    found="$(python3 "$here/in_zsh.py" "$folder/zsh" "${line%:*}")"
    [[ "$found" == "${line#*:}" ]] || fail "zsh makes '$found' of '${line%:*}'"
  done
fi
if command -v fish >/dev/null; then
  in_fish() { fish --no-config -c "cat '$folder'/fish/*.fish | source; complete -C '$1'"; }
  [[ "$(in_fish "piste-replay " | head -1)" == run.yaml ]] || fail "fish completes $(in_fish "piste-replay ")"
  [[ "$(in_fish "piste-inspect l")" == log.csv ]] || fail "fish completes $(in_fish "piste-inspect l")"
  in_fish "piste-replay --ou" | grep -q "^--output.folder for the outputs" || fail "fish completes $(in_fish "piste-replay --ou")"
fi
rm -r "$PWD"
