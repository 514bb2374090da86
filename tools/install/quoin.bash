# Completion of the command quoin in bash. `source tools/setup.sh` reads it; `cmake --install` puts it where bash-completion looks.

_quoin_commands="new import check run show report study ensemble readings limit motion compare export help"
_quoin_topics=""  # asked for once
_quoin_keys=""

# options of a command, from its own help
_quoin_options() {
  quoin "$1" -h 2>/dev/null | grep -oE -- '(^|[ ,[])--?[a-z][a-z-]*' | tr -d ' ,[' | sort -u
}

_quoin() {
  local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} names="" files='!*'
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W "$_quoin_commands --version -h" -- "$word")
    return
  fi
  case $command in
    help)
      [ -n "$_quoin_topics" ] || _quoin_topics="$(quoin help 2>/dev/null | sed -n '2,/^Chapters/{/^  /p}' | tr -d ',') $_quoin_commands"
      mapfile -t COMPREPLY < <(compgen -W "$_quoin_topics" -- "$word")
      return ;;
    run | study | limit | ensemble | readings) files='!*.@(yaml|yml)' ;;
    check) files='!*.@(yaml|yml|h5)' ;;
    import) files='!*.@(yaml|yml|msh)' names="dam voronoi walls" ;;
  esac
  if [[ $word == -* ]]; then
    case $command in
      run | check | study)
        [ -n "$_quoin_keys" ] || _quoin_keys=$(quoin -help 2>/dev/null | sed -n 's/^| `\([a-z_.]*\)`.*/-\1/p' | tr . _)
        names="$(_quoin_options "$command") $_quoin_keys" ;;
      *) names=$(_quoin_options "$command") ;;
    esac
    mapfile -t COMPREPLY < <(compgen -W "$names" -- "$word")
    return
  fi
  local extended
  extended=$(shopt -p extglob)
  shopt -s extglob
  mapfile -t COMPREPLY < <(compgen -W "$names" -- "$word"; compgen -f -X "$files" -- "$word"; compgen -d -- "$word")
  $extended
  compopt -o filenames 2>/dev/null
}

complete -F _quoin quoin
