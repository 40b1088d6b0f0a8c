# Completion of trackbed in bash: commands, options, files, and parameters (section.key=) after a
# deck.
_trackbed() {
  local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]}
  if [ "$COMP_CWORD" -eq 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W "run resume check describe schema info shapes --help \
--version" -- "$word")
    return
  fi
  case $word in
    -*)
      mapfile -t COMPREPLY < <(compgen -W "$("${COMP_WORDS[0]}" "$command" --help 2>/dev/null |
        grep -o -e '--[a-z][a-z-]*')" -- "$word") ;;
    *.*)
      # `describe` states parameters as rows of a table: | key | kind | ...; sections are headings.
      mapfile -t COMPREPLY < <(compgen -W "$("${COMP_WORDS[0]}" describe 2>/dev/null |
        awk '/^## `/ { section = $0; gsub(/[^a-z_.]/, "", section) }
             /^\| `/ { gsub(/`/, "", $2); print section "." $2 "=" }')" -- "$word")
      compopt -o nospace ;;
  esac
}
complete -o default -o bashdefault -F _trackbed trackbed
