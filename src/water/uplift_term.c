/* uplift_term.c: makes uplift in joints a force term. The memory of the term is an Uplift for each load of
   the scene. */
#include "water/uplift.h"
#include "scene/reader.h"

static PetscBool act_together(const Scene *scene, PetscInt a, PetscInt b)
{
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++) {
    PetscBool with_a = PETSC_FALSE, with_b = PETSC_FALSE;
    for (PetscInt i = 0; i < s->n_loads; i++) {
      with_a = (PetscBool)(with_a || s->loads[i] == a);
      with_b = (PetscBool)(with_b || s->loads[i] == b);
    }
    if (with_a && with_b) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Collective. Decides whether a face of a set ends at a place of the mesh. */
static PetscErrorCode ends_at(const Model *m, const char *set, const PetscReal place[2], PetscReal near,
                              PetscBool *does)
{
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, set, &n);
  PetscFunctionBeginUser;
  *does = PETSC_FALSE;
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscReal *X = m->mesh.X + 2 * m->faces.vertex[2 * faces[i / 2] + i % 2];
    if (PetscAbsReal(X[0] - place[0]) <= near && PetscAbsReal(X[1] - place[1]) <= near) *does = PETSC_TRUE;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, does, 1, MPIU_BOOL, MPI_LOR, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Warns of a joint whose toe lies under water while its load has no tailwater: nothing presses
   there. The toe may be the upper end of a crack. */
static PetscErrorCode warn_of_toe(const TermView *v, PetscInt uplift, const Uplift *u)
{
  const Load *load = v->scene->loads + uplift;
  const PetscReal near = 1e-3 * u->length;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(v->m->comm, &rank));
  for (PetscInt l = 0; l < v->scene->n_loads; l++) {
    const Load *water = v->scene->loads + l;
    PetscBool meets;
    if (water->kind != LOAD_RESERVOIR && water->kind != LOAD_OVERFLOW && water->kind != LOAD_TAILWATER)
      continue;
    if (!(water->level > u->toe[1] + near) || !act_together(v->scene, uplift, l)) continue;
    PetscCall(ends_at(v->m, water->target, u->toe, near, &meets));
    if (!meets || rank) continue;
    Warn("loads.%s: tailwater is not given, so no water presses at its end (%.6g, %.6g) m, "
         "which lies %.4g m under the water of loads.%s",
         load->name, (double)u->toe[0], (double)u->toe[1], (double)(water->level - u->toe[1]), water->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of an earthquake with a cracked uplift that has not acted before: the crack without the earthquake
   is unknown. */
static void warn_of_earthquake(const Scene *scene, PetscInt uplift)
{
  const Load *load = scene->loads + uplift;
  for (const Stage *stage = scene->stages; stage < scene->stages + scene->n_stages; stage++) {
    const Stage *before = StageBefore(scene, stage);
    PetscBool acts = PETSC_FALSE, acted = PETSC_FALSE;
    for (PetscInt i = 0; i < stage->n_loads; i++) acts = (PetscBool)(acts || stage->loads[i] == uplift);
    for (PetscInt i = 0; before && i < before->n_loads; i++)
      acted = (PetscBool)(acted || before->loads[i] == uplift);
    if (!load->uplift.cracked || !acts || acted || UpliftInEarthquake(scene, stage, load) == SHAKEN_FULL)
      continue;
    Warn("stages.%s: %s does not act in the stage before, so the joint counts as closed "
         "before the "
         "earthquake: expected a stage with the same loads without it",
         stage->name, load->name);
  }
}

static PetscErrorCode create(const TermView *v, void **memory)
{
  static PetscBool warned = PETSC_FALSE; // only once, because advise.c sets up the same mesh many times
  Uplift *all;
  PetscFunctionBeginUser;
  PetscCall(UpliftCreate(v->scene, v->m, v->contacts, &all));
  for (PetscInt l = 0; l < v->scene->n_loads && !warned; l++)
    if (all[l].length > 0. && PetscIsNanReal(v->scene->loads[l].uplift.tailwater))
      PetscCall(warn_of_toe(v, l, all + l));
  for (PetscInt l = 0; l < v->scene->n_loads && !warned && !v->m->rank; l++)
    if (all[l].length > 0.) warn_of_earthquake(v->scene, l);
  warned = PETSC_TRUE;
  *memory = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  Uplift *all = *memory;
  PetscFunctionBeginUser;
  PetscCall(UpliftDestroy(scene, &all));
  *memory = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode applied(const TermView *v, PetscInt load, PetscReal *f)
{
  const Uplift *all = v->memory;
  PetscFunctionBeginUser;
  UpliftForces(v, v->scene->loads + load, all + load, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode history(const TermView *v, TermHistory what)
{
  Uplift *all = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < v->scene->n_loads; l++) {
    if (what == KEEP_STABLE) all[l].crack_stable = all[l].crack, all[l].opened_stable = all[l].opened;
    if (what == BACK_TO_STABLE) all[l].crack = all[l].crack_stable, all[l].opened = all[l].opened_stable;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive(Archive *a, const TermView *v)
{
  Uplift *all = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < v->scene->n_loads; l++) {
    const Load *load = v->scene->loads + l;
    char label[NAME_LENGTH + 16];
    if (load->kind != LOAD_UPLIFT) continue;
    PetscCall(PetscSNPrintf(label, sizeof(label), "crack_%s", load->name));
    PetscCall(ArchiveReals(a, label, 1, &all[l].crack));
    PetscCall(PetscSNPrintf(label, sizeof(label), "opened_%s", load->name));
    PetscCall(ArchiveReals(a, label, 1, &all[l].opened));
    PetscCall(PetscSNPrintf(label, sizeof(label), "rounds_%s", load->name));
    PetscCall(ArchiveTally(a, label, 1, &all[l].rounds));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_stable(Archive *a, const TermView *v)
{
  const PetscInt n = v->scene->n_loads;
  Uplift *all = v->memory;
  PetscReal *crack;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * n, &crack));
  for (PetscInt l = 0; l < n; l++) crack[l] = all[l].crack_stable, crack[n + l] = all[l].opened_stable;
  PetscCall(ArchiveReals(a, "crack", 2 * n, crack));
  for (PetscInt l = 0; l < n; l++) all[l].crack_stable = crack[l], all[l].opened_stable = crack[n + l];
  PetscCall(PetscFree(crack));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the open stretches without the full head, with the force [N] of the full head there. unit: [N/m2]
   unit weight of the water times thickness. */
static void put_dry(Json *json, const Load *load, const Uplift *u, PetscReal unit)
{
  JsonList(json, "dry");
  for (PetscInt i = 0; i < u->n_dry; i++) {
    const UpliftDry *d = u->dry + i;
    JsonOpen(json, NULL);
    JsonNumbers(json, {"from", d->from}, {"to", d->to}, {"length", d->to - d->from},
                {"force", unit * UpliftFullHead(load, u, 0.5 * (d->from + d->to)) * (d->to - d->from)},
                {"closed_from", d->closed_from}, {"closure", d->closure});
    JsonValue(json, "at_toe", d->at_toe ? "true" : "false");
    JsonClose(json);
  }
  JsonClose(json);
}

/* Writes for each acting uplift load its open length, and its diagram with the resultants on both sides of
   the drain. */
static void summary(Json *json, const TermView *v)
{
  const Scene *scene = v->scene;
  const Stage *stage = v->stage;
  JsonOpenLater(json, "uplift");
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const Load *load = scene->loads + stage->loads[i];
    const Uplift *u = (const Uplift *)v->memory + stage->loads[i];
    UpliftDiagram d;
    PetscReal part[2] = {0., 0.};
    if (load->kind != LOAD_UPLIFT) continue;
    UpliftPressure(load, u, scene->gravity, &d);
    for (PetscInt k = 0; k + 1 < d.n; k++)
      part[d.s[k] >= load->uplift.drain] += 0.5 * (d.p[k] + d.p[k + 1]) * (d.s[k + 1] - d.s[k]) *
                                            scene->thickness;
    JsonOpen(json, load->name);
    JsonText(json, "heel", u->at_end ? "end" : "start");
    JsonNumber(json, "open_length", u->crack);
    if (u->opened > u->crack) JsonNumber(json, "opened_by_earthquake", u->opened);
    JsonNumbers(json, {"rounds", u->rounds}, {"length", u->length}, {"to_drain", part[0]},
                {"beyond_drain", part[1]});
    if (load->uplift.cracked) put_dry(json, load, u, load->density * scene->gravity * scene->thickness);
    JsonList(json, "diagram");
    for (PetscInt k = 0; k < d.n; k++) {
      JsonList(json, NULL);
      JsonNumbers(json, {NULL, d.s[k]}, {NULL, d.p[k]});
      JsonClose(json);
    }
    JsonClose(json);
    JsonClose(json);
  }
  JsonClose(json);
}

/* ---- keys */

/* Completes the keys of an uplift rule: npb and usbr reduce the head at the drain to one third; usace and
   ferc need the efficiency of the drain. */
PetscErrorCode CompleteUplift(Reader *r, const char *path, Load *load)
{
  const PetscBool fixed = (PetscBool)(load->uplift.rule == UPLIFT_NPB || load->uplift.rule == UPLIFT_USBR);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  load->uplift.drain_level = load->level;
  PetscCall(IsGiven(r, path, "gallery", &given));
  if (given && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  if (given && fixed) COMPLAIN(r, "the rules npb and usbr know no gallery; usace and ferc do");
  PetscCall(IsGiven(r, path, "efficiency", &given));
  if (given && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  if (given && fixed) COMPLAIN(r, "the rules npb and usbr fix it at 2/3; usace and ferc take a value");
  if (fixed) load->uplift.efficiency = 2. / 3.;
  if (load->uplift.rule != UPLIFT_LINEAR && !isnan(load->uplift.drain) && isnan(load->uplift.efficiency))
    COMPLAIN_MISSING(r, "missing [-]: the rules usace and ferc need it");
  PetscCall(IsGiven(r, path, "drain", &given));
  if (given && load->uplift.rule == UPLIFT_LINEAR)
    COMPLAIN(r, "the rule linear knows no drain: choose npb, usbr, usace or ferc");
  PetscCall(IsGiven(r, path, "reaches", &given));
  if (load->uplift.reaches == REACHES_ANY && !load->uplift.cracked) COMPLAIN(r, "it is for cracked: true");
  PetscCall(IsGiven(r, path, "in_earthquake", &given));
  if (load->uplift.shaken != SHAKEN_RULE && !load->uplift.cracked) COMPLAIN(r, "it is for cracked: true");
  PetscCall(IsGiven(r, path, "raise", &given));
  if (load->uplift.raise == RAISE_TO_DRAIN && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Uplift_term = {.name = "uplift",
                              .loads = 1u << LOAD_UPLIFT,
                              .presses = PETSC_TRUE,
                              .create = create,
                              .destroy = destroy,
                              .applied = applied,
                              .begin = UpliftStart,
                              .settle = UpliftCrack,
                              .before_summary = UpliftFindDry,
                              .history = history,
                              .archive = archive,
                              .archive_stable = archive_stable,
                              .summary = summary};
