/* advise.c: estimates the cost of a run, and which parts of the scene could be simpler (key `advise`). The
   scene is tried unchanged, and then with one change at a time (study.h). The saving of each change, and
   the change of the answers, are measured against the unchanged scene on the same mesh. */
#include "study/study.h"
#include "base/memory.h"

enum { MOST_RIGID = 4, MOST_VARIANTS = 6 + MOST_RIGID, OPTION = 4 * NAME_LENGTH, TAKEN = 80 };
static const double PAYS = 1.2; /* a change must be this many times faster to be named */

/* The scene with one change. */
typedef struct {
  char what[128];
  char *options; /* "-key\nvalue\n" ... */
  Attempt attempt;
  PetscReal difference[2]; /* AttemptDifference from the unchanged scene; rank 0 */
} Variant;

typedef struct {
  MPI_Comm comm;
  PetscMPIInt rank;
  const Scene *scene;
  MethodKind method; /* method of the scene */
  const Model *m;
  Attempt base;
  PetscInt most_options; /* of a variant, each of at most OPTION bytes */
  PetscInt n;
  Variant variant[MOST_VARIANTS];
} Advisor;

/* ---- what may be changed */

static PetscBool has_kind(const Scene *scene, PetscBool (*is)(const Stage *))
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (is(scene->stages + s)) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscBool is_dynamic(const Stage *s)
{
  return StageInTime(s);
}
static PetscBool is_variable(const Stage *s)
{
  return (PetscBool)(s->connectivity == CONNECTIVITY_VARIABLE);
}

/* Adds the variant `what`, in which `key` has another value in all joints that have a finer stress model, in
   all groups that deform on their own, or in the group `only` (-1: all). Adds none where nothing changes. */
static PetscErrorCode add_variant(Advisor *a, const char *what, PetscBool joints, PetscInt only,
                                  const char *key, const char *value)
{
  const Scene *scene = a->scene;
  const PetscInt n = joints ? scene->n_joints : scene->n_materials;
  Variant *v = a->variant + a->n;
  char *end;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(v, sizeof(*v)));
  PetscCall(PetscStrncpy(v->what, what, sizeof(v->what)));
  PetscCall(PetscCalloc1(a->most_options * OPTION, &v->options));
  end = v->options;
  for (PetscInt i = 0; i < n; i++) {
    const Joint *joint = joints ? scene->joints + i : NULL;
    const Material *group = joints ? NULL : scene->materials + i;
    PetscBool changes = PETSC_FALSE;
    if (joint)
      changes = (PetscBool)(joint->defined && joint->stress_model != STRESS_PT &&
                            strcmp(StressModels[joint->stress_model], value) != 0);
    else
      changes = (PetscBool)(only < 0 ? !MaterialBody(group) : i == only);
    if (!changes) continue;
    const char *name = joint ? joint->name : group->name;
    end += snprintf(end, OPTION, "-%s_%s_%s\n%s\n", joint ? "joints" : "materials", name, key, value);
    if (group && only >= 0 && group->condensed > 0)
      end += snprintf(end, OPTION, "-materials_%s_condensed\nfalse\n", name);
  }
  a->n += end > v->options;
  if (end == v->options) PetscCall(PetscFree(v->options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds simpler stress models, blocks of one point, condensed bodies, rigid groups, small strain. */
static PetscErrorCode add_variants(Advisor *a)
{
  const Scene *scene = a->scene;
  const PetscBool still = (PetscBool)(!has_kind(scene, is_dynamic) && !has_kind(scene, is_variable));
  PetscBool full = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(add_variant(a, "joints: t2pt", PETSC_TRUE, -1, "stress_model", "t2pt"));
  PetscCall(add_variant(a, "joints: pt", PETSC_TRUE, -1, "stress_model", "pt"));
  for (PetscInt g = 0; g < scene->n_materials && a->m->mesh.q4.n_padded; g++)
    full = (PetscBool)(full ||
                       (!MaterialBody(scene->materials + g) && scene->materials[g].element == ELEMENT_FULL));
  if (full) PetscCall(add_variant(a, "blocks: bending", PETSC_FALSE, -1, "element", "bending"));
  if (full) PetscCall(add_variant(a, "blocks: reduced", PETSC_FALSE, -1, "element", "reduced"));
  if (still) PetscCall(add_variant(a, "bodies: condensed", PETSC_FALSE, -1, "condensed", "true"));
  for (PetscInt g = 0; g < scene->n_materials && g < MOST_RIGID; g++) {
    char what[128];
    if (scene->materials[g].rigid) continue;
    snprintf(what, sizeof(what), "rigid: %s", scene->materials[g].name);
    PetscCall(add_variant(a, what, PETSC_FALSE, g, "rigid", "true"));
  }
  if (still && scene->strain != STRAIN_SMALL) {
    Variant *v = a->variant + a->n++;
    PetscCall(PetscMemzero(v, sizeof(*v)));
    snprintf(v->what, sizeof(v->what), "strain: small");
    PetscCall(PetscCalloc1(a->most_options * OPTION, &v->options));
    char *end = v->options + snprintf(v->options, OPTION, "-strain\nsmall\n");
    for (PetscInt g = 0; g < scene->n_materials; g++) // small strain alone: condensed bodies are a variant
      if (scene->materials[g].is_open && !MaterialBody(scene->materials + g))
        end += snprintf(end, OPTION, "-materials_%s_condensed\nfalse\n", scene->materials[g].name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads and tries a variant: argv of the run, then the variant's options. */
static PetscErrorCode try_variant(Advisor *a, const char *scene_file, int argc, char **argv, Variant *v)
{
  char *text, **words;
  int n = argc;
  PetscFunctionBeginUser;
  PetscCall(PetscStrallocpy(v->options, &text));
  PetscCall(PetscMalloc1(argc + 2 * a->most_options, &words));
  for (int i = 0; i < argc; i++) words[i] = argv[i];
  for (char *word = strtok(text, "\n"); word; word = strtok(NULL, "\n")) words[n++] = word;
  PetscCall(AttemptRun(a->comm, scene_file, n, words, &v->attempt));
  if (!a->rank && !v->attempt.refused[0]) AttemptDifference(&v->attempt, &a->base, v->difference);
  PetscCallMPI(MPI_Bcast(v->difference, 2, MPIU_REAL, 0, a->comm));
  PetscCall(PetscFree(words));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what is printed */

/* Writes a number for a column; "-" when it is not known. */
static const char *format_number(double value, const char *format, char text[32])
{
  if (isfinite(value))
    snprintf(text, 32, format, value);
  else
    snprintf(text, 32, "-");
  return text;
}

/* [-] Memory of the factor of a tangent with joints that slip, which is not symmetric, over the memory of the
   factor of the elastic stiffness; both are kept. Measured on one rank: 70 x 70 single blocks, 40 x 40 bodies
   of 16. */
static const double TANGENT_FACTOR = 1.4;

/* Prints the memory that the run needs, before anything is factorised. */
static PetscErrorCode print_memory(const Advisor *a, const Contacts *contacts)
{
  const Model *m = a->m;
  const PetscBool fails = SceneCanFail(a->scene);
  double first[2] = {0., 0.}, sum[2] = {0., 0.}, memory[2];
  PetscInt n[2];
  PetscBool fits;
  PetscFunctionBeginUser;
  PetscCall(AttemptContacts(m, contacts, n));
  PetscCall(NewtonFits(m, PETSC_FALSE, memory, &fits));
  for (PetscMPIInt rank = m->size - 1; rank >= 0; rank--) {
    first[0] = MemoryOfRank(m->mesh.n_vertices_global, m->mesh.n_blocks_global, (double)n[0], m->size, rank);
    first[1] = MemoryOfNewton(m->mesh.n_vertices_global, m->mesh.n_blocks_global, (double)n[0],
                              (fails ? 1. + TANGENT_FACTOR : 1.) * memory[0], m->size, rank);
    for (int method = 0; method < 2; method++) {
      if (fails) first[method] += MemoryOfFailing(m->mesh.n_vertices_global, m->size, rank);
      sum[method] += first[method];
    }
  }
  PetscCall(PetscPrintf(a->comm, "%-44s %12s %12s\n", "memory [MB]", "rank 0", "all ranks"));
  for (int method = 0; method < 2; method++)
    PetscCall(PetscPrintf(a->comm, "%-44s %12.0f %12.0f\n", method ? "preconditioned" : "explicit",
                          1e-6 * first[method], 1e-6 * sum[method]));
  if (!fits)
    PetscCall(PetscPrintf(a->comm,
                          "preconditioned: not tried, its factor takes %.0f MB and %.0f MB are available\n",
                          1e-6 * memory[0], 1e-6 * memory[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the effort of an attempt that was given up. */
static const char *describe_effort(const Attempt *t, char text[TAKEN])
{
  snprintf(text, TAKEN, "%lld force evaluations, %lld solves", (long long)t->spent.evaluations,
           (long long)t->spent.solves);
  return text;
}

/* Prints why a column has "-". */
static PetscErrorCode print_unknown(const Advisor *a)
{
  PetscBool any = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < a->base.n_stages; s++)
    any = (PetscBool)(any || !isfinite((double)a->base.cost[s].most));
  if (any)
    PetscCall(PetscPrintf(
        a->comm, "-: not known. Cycles have no upper end where no equilibrium was found, and where many "
                 "of more than a thousand bodies slip or are open; >: the least, for stones that slide took "
                 "2 to 15 times what elastic motions take\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the cycles of a stage, or seconds at `each` a cycle: the likely number, or the least number with a
   mark where there may be any number of cycles. */
static const char *format_cost(const Cost *c, double each, const char *format, char text[40])
{
  char plain[32];
  const PetscBool open = (PetscBool)(isfinite((double)c->cycles) && !isfinite((double)c->most));
  snprintf(text, 40, "%s%s", open ? ">" : "",
           format_number((double)(open ? c->least : c->cycles) * each, format, plain));
  return text;
}

/* Prints the cost of each stage. */
static PetscErrorCode print_stages(const Advisor *a)
{
  const Attempt *b = &a->base;
  char text[6][32], bound[2][40], taken[TAKEN];
  PetscFunctionBeginUser;
  if (b->cycle > 0.)
    PetscCall(PetscPrintf(
        a->comm,
        "explicit: %.3g us a cycle, lowest frequency %s a cycle, %.0f %% of the contacts slip or "
        "are open\n",
        1e6 * b->cycle, format_number(b->omega > 0. ? (double)b->omega : (double)NAN, "%.3g", text[0]),
        100. * (double)b->loose));
  if (b->step > 0.) PetscCall(PetscPrintf(a->comm, "in time: %.3g us a step\n", 1e6 * b->step));
  PetscCall(PetscPrintf(a->comm, "%-16s %7s %12s %23s %14s %18s\n", "stage", "trials", "cycles", "range",
                        "explicit [s]", "preconditioned [s]"));
  for (PetscInt s = 0; s < b->n_stages; s++) {
    const Stage *stage = a->scene->stages + s;
    const Cost *c = b->cost + s;
    const double each = StageInTime(stage) ? b->step : b->cycle;
    PetscCall(PetscPrintf(
        a->comm, "%-16s %7s %12s %11s %11s %14s %18s\n", stage->name,
        format_number((double)c->trials, "%.0f", text[5]), format_cost(c, 1., "%.0f", bound[0]),
        format_number((double)c->least, "%.0f", text[1]), format_number((double)c->most, "%.0f", text[2]),
        format_cost(c, each, "%.3g", bound[1]), format_number(c->seconds, "%.3g", text[4])));
  }
  PetscCall(PetscPrintf(a->comm, "%-16s %12s %23s %12s %23s\n", "preconditioned", "evaluations", "range",
                        "solves", "range"));
  for (PetscInt s = 0; s < b->n_stages; s++) {
    const PetscReal *e = b->cost[s].effort[0];
    for (int i = 0; i < 6; i++) (void)format_number((double)e[i], "%.0f", text[i]);
    PetscCall(PetscPrintf(a->comm, "%-16s %12s %11s %11s %12s %11s %11s\n", a->scene->stages[s].name, text[0],
                          text[1], text[2], text[3], text[4], text[5]));
  }
  PetscCall(print_unknown(a));
  if (b->spent.evaluations)
    PetscCall(PetscPrintf(a->comm, "preconditioned: given up after %s\n", describe_effort(b, taken)));
  if (b->n_solved && !b->solved)
    PetscCall(PetscPrintf(a->comm,
                          "no equilibrium of the first stages was found: their answers, and what leaving out "
                          "changes, are not known\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode print_row(const Advisor *a, const char *what, const Attempt *t, const PetscReal d[2])
{
  char text[4][32], taken[TAKEN];
  PetscFunctionBeginUser;
  if (t->refused[0]) {
    PetscCall(PetscPrintf(a->comm, "%-24s refused: %s\n", what, t->refused));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscPrintf(a->comm, "%-24s %10.3g %14s %18s %14s %14s%s%s\n", what, 1e6 * t->cycle,
                        format_number(AttemptSeconds(a->scene, t, METHOD_EXPLICIT), "%.3g", text[0]),
                        format_number(AttemptSeconds(a->scene, t, METHOD_PRECONDITIONED), "%.3g", text[1]),
                        format_number(100. * (double)d[0], "%.3g", text[2]),
                        format_number(100. * (double)d[1], "%.3g", text[3]),
                        t->spent.evaluations ? " given up after " : "",
                        t->spent.evaluations ? describe_effort(t, taken) : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether all stages that are not dynamic use this method already, as far as they can. */
static PetscBool has_method(const Advisor *a, MethodKind how)
{
  if (a->method != METHOD_AUTO) return (PetscBool)(a->method == how);
  for (PetscInt s = 0; s < a->base.n_stages; s++)
    if (StageRelaxes(a->scene->stages + s) && a->base.method[s] != how) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Prints the cheapest way: the scene or a variant whose first `answers` stay within the accuracy. */
static PetscErrorCode print_cheapest(const Advisor *a, const char *kept, PetscBool displacements)
{
  const double now = AttemptSeconds(a->scene, &a->base, METHOD_AUTO);
  const Variant *best = NULL;
  double least = PETSC_MAX_REAL;
  MethodKind how = METHOD_EXPLICIT;
  PetscFunctionBeginUser;
  for (PetscInt i = -1; i < a->n; i++) {
    const Attempt *t = i < 0 ? &a->base : &a->variant[i].attempt;
    const PetscReal *d = i < 0 ? NULL : a->variant[i].difference;
    if (t->refused[0] || (d && !(d[1] <= a->scene->advise && (!displacements || d[0] <= a->scene->advise))))
      continue;
    const double seconds[2] = {AttemptSeconds(a->scene, t, METHOD_EXPLICIT),
                               AttemptSeconds(a->scene, t, METHOD_PRECONDITIONED)};
    for (int method = 0; method < 2; method++)
      if (seconds[method] < least)
        least = seconds[method], how = (MethodKind)method, best = i < 0 ? NULL : a->variant + i;
  }
  if (least == PETSC_MAX_REAL || !(now > PAYS * least)) {
    PetscCall(PetscPrintf(a->comm, "%s within %.3g %%: the scene as it is\n", kept,
                          100. * (double)a->scene->advise));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscPrintf(a->comm, "%s within %.3g %%: %s%s%s, %.3g s instead of %.3g s:", kept,
                        100. * (double)a->scene->advise, best ? best->what : "", best ? ", " : "",
                        how == METHOD_EXPLICIT ? "explicit" : "preconditioned", least, now));
  for (const char *c = best ? best->options : "", *line = c; *c; c++)
    if (*c == '\n') {
      PetscCall(PetscPrintf(a->comm, " %.*s", (int)(c - line), line));
      line = c + 1;
    }
  if (!has_method(a, how))
    PetscCall(PetscPrintf(a->comm, " -relaxation_method %s",
                          how == METHOD_EXPLICIT ? "explicit" : "preconditioned"));
  PetscCall(PetscPrintf(a->comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the stages whose answers, such as where trials fail, were compared with nothing. */
static PetscErrorCode print_untried(const Advisor *a)
{
  PetscBool any = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < a->scene->n_stages; s++) {
    const Stage *stage = a->scene->stages + s;
    if (s < a->base.n_solved && stage->kind == STAGE_STATIC) continue; // of trials only the start is solved
    if (StageEvaluates(stage)) continue;
    PetscCall(PetscPrintf(a->comm, "%s %s", any ? "," : "not tried:", stage->name));
    any = PETSC_TRUE;
  }
  if (any)
    PetscCall(PetscPrintf(a->comm,
                          ": what is left out may change more there; condensed bodies that turn too far "
                          "end the run, exit code 2\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints whether variable connectivity is needed: perhaps nothing moves far enough for it. */
static PetscErrorCode print_connectivity(const Advisor *a)
{
  const PetscReal moved = a->base.moved;
  PetscFunctionBeginUser;
  if (!has_kind(a->scene, is_variable) || !a->base.solved) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      PetscPrintf(a->comm,
                  "connectivity: with contacts kept, blocks move %.3g of the way after which contacts are "
                  "found again; finding them takes %.3g s: fixed would %s\n",
                  (double)moved, a->base.search,
                  moved < 1. ? "give the same answers and allows preconditioned" : "not do"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Advise(Quoin q, const char *scene_file, int argc, char **argv, PetscBool *advised)
{
  static const PetscReal none[2] = {0., 0.};
  Scene *scene;
  Model *m;
  State *state;
  Contacts *contacts;
  Relaxation *relax;
  PetscFunctionBeginUser;
  PetscCall(QuoinGetParts(q, &scene, &m, &state, &contacts, &relax));
  *advised = (PetscBool)(scene->advise > 0.);
  if (!*advised) PetscFunctionReturn(PETSC_SUCCESS);
  SignalsRelease();
  Advisor a = {.comm = m->comm, .rank = m->rank, .scene = scene, .method = scene->method, .m = m};
  a.most_options = 2 * scene->n_materials + scene->n_joints + 1;
  PetscCall(print_memory(&a, contacts));
  PetscCall(AttemptMeasure(q, &a.base));
  PetscCall(print_stages(&a));
  PetscCall(print_connectivity(&a));
  if (a.base.solved) {
    PetscCall(add_variants(&a));
    PetscCall(
        PetscPrintf(a.comm,
                    "\nleft out, stages that are not dynamic; change: of displacements over the largest, of "
                    "joint forces over their sum, at the end of %s\n%-24s %10s %14s %18s %14s %14s\n",
                    scene->stages[a.base.n_solved - 1].name, "", "us a cycle", "explicit [s]",
                    "preconditioned [s]", "moved [%]", "joints [%]"));
    PetscCall(print_row(&a, "the scene as it is", &a.base, none));
    for (PetscInt i = 0; i < a.n; i++) {
      PetscCall(try_variant(&a, scene_file, argc, argv, a.variant + i));
      PetscCall(print_row(&a, a.variant[i].what, &a.variant[i].attempt, a.variant[i].difference));
    }
    PetscCall(print_cheapest(&a, "displacements and joint forces", PETSC_TRUE));
    PetscCall(print_cheapest(&a, "joint forces alone", PETSC_FALSE));
    PetscCall(print_untried(&a));
  }
  for (PetscInt i = 0; i < a.n; i++) {
    PetscCall(AttemptDestroy(&a.variant[i].attempt));
    PetscCall(PetscFree(a.variant[i].options));
  }
  PetscCall(AttemptDestroy(&a.base));
  PetscFunctionReturn(PETSC_SUCCESS);
}
