/* help.c: prints the table of keys for -help, which docs/generated/keys.md contains. */
#include "scene/scene.h"
#include "scene/keys.h"
#include <stdio.h>

// Describes the allowed values of a key.
static void describe_values(const Key *key, char text[256])
{
  static const char *const words[] = {[TYPE_TITLE] = "text",
                                      [TYPE_PATH] = "path",
                                      [TYPE_NAME] = "name",
                                      [TYPE_REAL] = "number",
                                      [TYPE_LIMIT] = "inf or number",
                                      [TYPE_INT] = "whole number",
                                      [TYPE_BOOL] = "true, false",
                                      [TYPE_TRISTATE] = "true, false",
                                      [TYPE_PAIR] = "[number, number]",
                                      [TYPE_NUMBERS] = "list of numbers",
                                      [TYPE_FIX] = "x, y, xy",
                                      [TYPE_MOTION] = "path or motions",
                                      [TYPE_NAMES] = "list of names",
                                      [TYPE_LOADS] = "list of loads",
                                      [TYPE_CHANGES] = "keys"};

  if (key->type == TYPE_CHOICE)
    DescribeChoices(key->choices, text);
  else
    snprintf(text, 256, "%s%s%s%s%s", words[key->type], key->range ? " " : "", key->range ? key->range : "",
             key->word ? " or " : "", key->word ? key->word : "");
}

PetscErrorCode SceneHelp(MPI_Comm comm)
{
  char path[LABEL_LENGTH], values[256];

  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(comm, "| key | default | unit | value | meaning |\n|---|---|---|---|---|\n"));
  for (const Key *key = Keys; key < Keys + KEYS; key++) {
    const char *preset = key->preset ? key->preset : "required";
    if (key->preset && !preset[0]) preset = "empty";
    if (preset[0] == '=') preset += 2;
    snprintf(path, sizeof path, "`%s%s`", SectionPaths[key->section], key->name);
    describe_values(key, values);
    PetscCall(PetscPrintf(comm, "| %-36s | %-29s | %-9s | %-26s | %s |\n", path, preset, key->unit, values,
                          key->help));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
