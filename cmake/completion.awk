# Turns what a program says to --help into its completion for bash: options, folders after --output, configurations (or
# any file, where the program takes logs) elsewhere.
#   PROGRAM --help | awk -v name=piste-replay -f completion.awk
/^Usage: / { many = /\.\.\.$/ }
/^  (-[a-z],)?--/ {
  text = $1
  sub(/^-[a-z],/, "", text)
  options = options (options ? " " : "") text
  if ($2 ~ /^[A-Z]+$/ && $2 != "DIR") numbers = numbers (numbers ? "|" : "") text
}
END {
  body = name
  gsub(/[^a-z0-9]/, "_", body)
  printf "# Completion of %s for bash, made from its --help.\n_%s() {\n", name, body
  printf "  local word=\"${COMP_WORDS[COMP_CWORD]}\" before=\"${COMP_WORDS[COMP_CWORD - 1]}\"\n"
  printf "  COMPREPLY=()\n  case \"$before\" in\n"
  printf "    --output) mapfile -t COMPREPLY < <(compgen -d -- \"$word\"); return ;;\n"
  if (numbers) printf "    %s) return ;;\n", numbers
  printf "  esac\n"
  printf "  if [[ \"$word\" == -* ]]; then\n"
  printf "    mapfile -t COMPREPLY < <(compgen -W \"%s\" -- \"$word\")\n  else\n", options
  printf "    mapfile -t COMPREPLY < <(%scompgen -f %s-- \"$word\")\n", many ? "" : "compgen -d -- \"$word\" || :; ",
    many ? "" : "-X '!*.yaml' "
  printf "  fi\n}\ncomplete -o filenames -F _%s %s\n", body, name
}
