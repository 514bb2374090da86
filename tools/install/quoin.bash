# Completion of the command quoin in bash. `source tools/setup.sh` reads it; `cmake --install` puts it where bash-completion looks.

_quoin_commands="new import check advise run show report study ensemble compare export schema help dam voronoi walls blockmesh plot_mesh section gmsh_import results plots animate assessment limit hinges motion whole verify"
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
    run | check | advise | study | limit | ensemble) files='!*.@(yaml|yml)' ;;
    import | section) files='!*.@(yaml|yml|msh)' ;;
    gmsh_import) files='!*.msh' ;;
    plot_mesh | blockmesh) files='!*.h5' ;;
  esac
  if [[ $word == -* ]]; then
    case $command in
      run | check | advise | study)
        [ -n "$_quoin_keys" ] || _quoin_keys=$(quoin -help 2>/dev/null | sed -n 's/^| `\([a-z_.]*\)`.*/-\1/p' | tr . _)
        names="-n -h $_quoin_keys" ;;
      *) names=$(_quoin_options "$command") ;;
    esac
    mapfile -t COMPREPLY < <(compgen -W "$names" -- "$word")
    return
  fi
  local extended
  extended=$(shopt -p extglob)
  shopt -s extglob
  mapfile -t COMPREPLY < <(compgen -f -X "$files" -- "$word"; compgen -d -- "$word")
  $extended
  compopt -o filenames 2>/dev/null
}

complete -F _quoin quoin
