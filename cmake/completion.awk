# Turns what a program says to --help into its completion for a shell: options with what they are, folders and files behind
# those that take one; configurations (or any file, where the program takes logs) elsewhere.
#   PROGRAM --help | awk -v name=piste-replay -v shell=bash -f completion.awk      shell: bash, zsh or fish
/^Usage: / { many = /\.\.\.$/ }
/^  (-[a-z],)?--/ {
  text = $1
  short[++count] = text ~ /^-[a-z],/ ? substr(text, 1, 2) : ""
  sub(/^-[a-z],/, "", text)
  option[count] = text
  value[count] = $2 ~ /^[A-Z]+$/ ? $2 : ""
  help = $0
  sub(/^ +[^ ]+( [A-Z]+)? +/, "", help)
  what[count] = help
}

# The text between single quotes, with a backslash before the characters that mean something there.
function quoted(text, special) {
  gsub(special, "\\\\&", text)
  return text
}

function bash(    i, all, folders, files, numbers, body) {
  for (i = 1; i <= count; ++i) {
    all = all (all ? " " : "") option[i]
    if (value[i] == "DIR") folders = folders (folders ? "|" : "") option[i]
    else if (value[i] == "FILE") files = files (files ? "|" : "") option[i]
    else if (value[i]) numbers = numbers (numbers ? "|" : "") option[i]
  }
  body = name
  gsub(/[^a-z0-9]/, "_", body)
  printf "# Completion of %s for bash, made from its --help.\n_%s() {\n", name, body
  printf "  local word=\"${COMP_WORDS[COMP_CWORD]}\" before=\"${COMP_WORDS[COMP_CWORD - 1]}\"\n"
  printf "  COMPREPLY=()\n  case \"$before\" in\n"
  if (folders) printf "    %s) mapfile -t COMPREPLY < <(compgen -d -- \"$word\"); return ;;\n", folders
  if (files) printf "    %s) mapfile -t COMPREPLY < <(compgen -f -- \"$word\"); return ;;\n", files
  if (numbers) printf "    %s) return ;;\n", numbers
  printf "  esac\n"
  printf "  if [[ \"$word\" == -* ]]; then\n"
  printf "    mapfile -t COMPREPLY < <(compgen -W \"%s\" -- \"$word\")\n  else\n", all
  printf "    mapfile -t COMPREPLY < <(%scompgen -f %s-- \"$word\")\n", many ? "" : "compgen -d -- \"$word\" || :; ",
    many ? "" : "-X '!*.yaml' "
  printf "  fi\n}\ncomplete -o filenames -F _%s %s\n", body, name
}

function zsh(    i, takes) {
  printf "#compdef %s\n# Completion of %s for zsh, made from its --help.\n_arguments \\\n", name, name
  for (i = 1; i <= count; ++i) {
    takes = value[i] == "DIR" ? ":folder:_files -/" : value[i] == "FILE" ? ":file:_files" : value[i] ? ":number: " : ""
    what[i] = quoted(what[i], "\\[|\\]|:")
    gsub(/'/, "'\\''", what[i])
    if (short[i]) printf "  '(- *)'{%s,%s}'[%s]' \\\n", short[i], option[i], what[i]
    else printf "  '%s%s[%s]%s' \\\n", option[i] == "--version" ? "(- *)" : "", option[i], what[i], takes
  }
  printf "  '%s'\n", many ? "*:file:_files" : "1:configuration:_files -g \"*.yaml\""
}

function fish(    i, takes) {
  printf "# Completion of %s for fish, made from its --help.\n", name
  printf "complete -c %s %s\n", name, many ? "-F" : "-k -x -a '(__fish_complete_suffix .yaml)'"
  for (i = 1; i <= count; ++i) {
    takes = value[i] == "DIR" ? " -x -a '(__fish_complete_directories)'" : value[i] == "FILE" ? " -r -F" : value[i] ? " -x" : ""
    printf "complete -c %s%s -l %s%s -d '%s'\n", name, short[i] ? " -s " substr(short[i], 2) : "", substr(option[i], 3), takes,
      quoted(what[i], "[\\\\']")
  }
}

END {
  if (shell == "bash") bash()
  else if (shell == "zsh") zsh()
  else if (shell == "fish") fish()
  else exit 2
}
