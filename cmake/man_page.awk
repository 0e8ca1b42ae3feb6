# Turns what a program says to --help into its man page.
#   PROGRAM --help | awk -v name=piste-replay -v version=0.1.0 -v others="piste-align piste-inspect" -f man_page.awk
function roff(text) {
  gsub(/\\/, "\\e", text)
  gsub(/-/, "\\-", text)
  sub(/^[.']/, "\\\\\\&&", text)
  return text
}
function blanks_off(text) { sub(/^ +/, "", text); return text }
NR == 1 {
  summary = $0
  first = summary  # its first sentence says what the program does; whatis shows it without capital and full stop
  sub(/\. .*/, "", first)
  sub(/\.$/, "", first)
  if (first ~ /^[A-Z][a-z]/) first = tolower(substr(first, 1, 1)) substr(first, 2)
  printf ".TH %s 1 \"\" \"piste %s\" \"piste\"\n", toupper(name), version
  printf ".SH NAME\n%s \\- %s\n", roff(name), roff(first)
  next
}
/^Usage: / {
  arguments = $0
  sub(/^Usage: [^ ]+ /, "", arguments)
  printf ".SH SYNOPSIS\n.B %s\n%s\n.SH DESCRIPTION\n%s\n", roff(name), roff(arguments), roff(summary)
  next
}
/^[A-Z][a-z ]*:$/ {
  printf ".SH %s\n", toupper(substr($0, 1, length($0) - 1))
  next
}
/^  / {  # a name of one or two words, two blanks or more, what it is; or only one of them
  text = blanks_off($0)
  place = match(text, /  +/)
  if ($0 ~ /^          /) {
    print roff(text)
  } else if (place) {
    printf ".TP\n.B %s\n%s\n", roff(substr(text, 1, place - 1)), roff(blanks_off(substr(text, place)))
  } else {
    printf ".TP\n.B %s\n", roff(text)
  }
  next
}
END {
  printf ".SH SEE ALSO\n"
  count = split(others, names, " ")
  for (i = 1; i <= count; ++i) {
    if (names[i] != name) printf "%s.BR %s (1)", (printed++ ? ",\n" : ""), roff(names[i])
  }
  printf "\n"
}
