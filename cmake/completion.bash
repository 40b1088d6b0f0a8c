# Completion of trackbed in bash: commands, options, files, sections (describe), and parameters
# (key=) after a deck. Elements of lists ([[stage]]) have names of their own and are not completed.
_trackbed_parameters() {
  # `describe all` states parameters as rows of tables, | `key` | kind | ..., below the heading of
  # their section.
  "$1" describe all 2>/dev/null | awk '
    /^## / { section = $0; list = /\[\[/ || /\[\]/
             gsub(/[^a-z_.]/, "", section); section = /Top of/ ? "" : section "." }
    /^\| `/ && !list { gsub(/`/, "", $2); print section $2 "=" }'
}

_trackbed() {
  local program=${COMP_WORDS[0]} command=${COMP_WORDS[1]} word=${COMP_WORDS[COMP_CWORD]}
  if [ "$COMP_CWORD" -eq 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W "run resume check describe schema info shapes kernel --help \
--version" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" "$command" --help 2>/dev/null |
      grep -o -e '--[a-z][a-z-]*')" -- "$word")
  elif [ "$command" = describe ]; then
    mapfile -t COMPREPLY < <(compgen -W "all $("$program" describe all 2>/dev/null |
      sed -n 's/^## `\[*\([a-z_.]*\)\]*`$/\1/p')" -- "$word")
  elif [ "$COMP_CWORD" -gt 2 ]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_trackbed_parameters "$program")" -- "$word")
    if [ ${#COMPREPLY[@]} -gt 0 ]; then compopt -o nospace; fi
  fi
}
complete -o default -o bashdefault -F _trackbed trackbed
