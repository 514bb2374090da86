/* lifts.c: builds the dam in stages. A group that a stage builds is absent before: its blocks have no
   stiffness, mass or strength of their own (their row of the materials is 0). Supports hold their vertices at
   the places in the mesh, and the search for contacts leaves out their faces. When the group is placed, the
   strain of its blocks counts from the present displacements of their vertices, some of which belong to older
   blocks too. */
#include "stages/stages.h"
#include <stdarg.h>

/* The absent groups of a model with lifts. */
struct _p_Lifts {
  PetscInt stage;   /* stage whose groups are present */
  PetscBool *built; /* (n_groups,) whether a stage builds the group; otherwise it is present from the start */
  Lame *lame;       /* stiffnesses of all groups when they are present */
  PetscReal *density, *hourglass;
  PetscInt n_stages;
  PetscReal **at; /* (n_stages,) [m] vertex arrays: displacements when a stage placed its groups; NULL: it has
                     placed none */
};

/* ---- what is there */

/* Returns the stage that builds a group, among a stage and the stages it starts from; -1: none of them. */
static PetscInt built_in(const Scene *scene, const Model *m, PetscInt group, PetscInt stage)
{
  if (!m->lifts->built[group]) return -1;
  while (stage >= 0 &&
         NameRow(scene->stages[stage].n_build, scene->stages[stage].build, m->materials.names[group]) < 0)
    stage = StageBase(scene, stage);
  return stage;
}

/* Collective. Makes the groups present that stand in a stage, and the others absent. */
static PetscErrorCode set_present(const Scene *scene, PetscInt stage, Model *m)
{
  Materials *materials = &m->materials;
  struct _p_Lifts *l = m->lifts;
  PetscReal *mass;
  PetscFunctionBeginUser;
  l->stage = stage;
  for (PetscInt g = 0; g < materials->n_groups; g++) {
    materials->absent[g] = (PetscBool)(l->built[g] && built_in(scene, m, g, stage) < 0);
    materials->lame[g] = materials->absent[g] ? (Lame){0., 0.} : l->lame[g];
    materials->density[g] = materials->absent[g] ? 0. : l->density[g];
    for (int i = 0; i < 3 && materials->hourglass; i++)
      materials->hourglass[3 * g + i] = materials->absent[g] ? 0. : l->hourglass[3 * g + i];
  }
  LawsPresent(m);
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &mass));
  PetscCall(ElementMasses(m, mass));
  PetscCall(PetscArraycpy(m->vertex_mass, mass, m->mesh.n_owned));
  PetscCall(PetscFree(mass));
  PetscCall(SupportsApply(scene, PETSC_FALSE, m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives placed blocks the displacements from which their strain counts. */
static PetscErrorCode count_strain(const Scene *scene, Model *m)
{
  const struct _p_Lifts *l = m->lifts;
  PetscInt *in;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->materials.n_groups, &in));
  for (PetscInt g = 0; g < m->materials.n_groups; g++) in[g] = built_in(scene, m, g, l->stage);
  for (int list = 0; list < DEFORMABLE_LISTS; list++) {
    Elements *e = m->mesh.elements + list;
    const size_t n = (size_t)e->n_nodes * (size_t)e->n_padded;
    if (!e->placed) PetscCall(PetscMalloc1(2 * n, &e->placed));
    PetscCall(PetscArrayzero(e->placed, 2 * n));
    for (PetscInt i = 0; i < e->n; i++) {
      const PetscReal *u = in[e->group[i]] >= 0 ? l->at[in[e->group[i]]] : NULL;
      for (int k = 0; k < e->n_nodes && u; k++)
        for (int x = 0; x < 2; x++)
          e->placed[(size_t)x * n + (size_t)VertexPlace(e, i, k)] = u[2 * VertexOf(e, i, k) + x];
    }
  }
  PetscCall(PetscFree(in));
  AtRest(scene, m);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up */

/* Writes a refusal; the first one stays in message. */
static void refuse(const Scene *scene, const Stage *stage, char message[MESSAGE_LENGTH], const char *format,
                   ...) PETSC_ATTRIBUTE_FORMAT(4, 5);
static void refuse(const Scene *scene, const Stage *stage, char message[MESSAGE_LENGTH], const char *format,
                   ...)
{
  char key[LABEL_LENGTH], text[MESSAGE_LENGTH];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  snprintf(key, sizeof key, "stages.%s", stage->name);
  Complain(message, scene->file, stage->line, key, "%s", text);
}

/* Joins the roots of vertices (by gid) that are linked by present blocks or by contacts. */
static PetscErrorCode join(const Model *m, const Contacts *c, PetscInt *parent)
{
  const PetscInt n = m->mesh.n_vertices_global;
  PetscInt *all, changed = 1;
  PetscFunctionBeginUser;
#define JOIN(v, w)                                                                                           \
  do {                                                                                                       \
    const PetscInt p = UnionRoot(parent, v), q = UnionRoot(parent, w);                                       \
    parent[PetscMax(p, q)] = PetscMin(p, q);                                                                 \
  } while (0)
  for (PetscInt v = 0; v < n; v++) parent[v] = v;
  for (const Elements *e = m->mesh.elements; e < m->mesh.elements + ELEMENT_LISTS; e++)
    for (PetscInt i = 0; i < e->n; i++)
      for (int k = 1; k < e->n_nodes && !m->materials.absent[e->group[i]]; k++)
        JOIN(m->mesh.vertex_gid[VertexOf(e, i, 0)], m->mesh.vertex_gid[VertexOf(e, i, k)]);
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0)
      JOIN(m->mesh.vertex_gid[c->vertex[CONTACT_ROW(i, ROW_P)]],
           m->mesh.vertex_gid[c->vertex[CONTACT_ROW(i, ROW_A)]]);
  PetscCall(PetscMalloc1(n, &all));
  while (changed) { // as in ContactsCheckSupport, until no rank knows another link
    for (PetscInt v = 0; v < n; v++) all[v] = UnionRoot(parent, v);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, (PetscMPIInt)n, MPIU_INT, MPI_MIN, m->comm));
    changed = 0;
    for (PetscInt v = 0; v < n; v++) {
      const PetscInt p = UnionRoot(parent, v), q = UnionRoot(parent, all[v]);
      if (p != q) parent[PetscMax(p, q)] = PetscMin(p, q), changed = 1;
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPIU_INT, MPI_MAX, m->comm));
  }
#undef JOIN
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Refuses a stage in which some present block is not linked to a vertex held in x and to one held
   in y. */
static PetscErrorCode check_hanging(const Scene *scene, const Stage *stage, const Model *m, const Contacts *c)
{
  const PetscInt n = m->mesh.n_vertices_global, at = 3 * m->rigid.n;
  PetscInt *parent;
  int *held;
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, &parent));
  PetscCall(PetscCalloc1(2 * n, &held));
  PetscCall(join(m, c, parent));
  for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d++) {
    const PetscInt v = d / 2;
    const PetscBool rigid = (PetscBool)(v >= m->mesh.n_deformable && v < m->mesh.n_moving);
    const PetscInt dof = rigid ? 3 * RigidOfVertex(m, v) + d % 2 : at + d;
    if (SupportRow(m, dof) >= 0) held[2 * UnionRoot(parent, m->mesh.vertex_gid[v]) + d % 2] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, held, (PetscMPIInt)(2 * n), MPI_INT, MPI_MAX, m->comm));
  for (const Elements *e = m->mesh.elements; e < m->mesh.elements + ELEMENT_LISTS && !message[0]; e++)
    for (PetscInt i = 0; i < e->n && !message[0]; i++) {
      const PetscInt v = VertexOf(e, i, 0), root = UnionRoot(parent, m->mesh.vertex_gid[v]);
      if (m->materials.absent[e->group[i]] || (held[2 * root] && held[2 * root + 1])) continue;
      refuse(
          scene, stage, message,
          "group %s hangs in the air (block %d at x = %.6g m, y = %.6g m): it shares no vertex and no joint "
          "with what a support holds (groups that no stage builds are there from the start)",
          m->materials.names[e->group[i]], (int)e->file[i], (double)m->mesh.X[2 * v],
          (double)m->mesh.X[2 * v + 1]);
    }
  PetscCall(PetscFree(parent));
  PetscCall(PetscFree(held));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether any or all faces of a set, or blocks at a point, are absent. The same on all ranks. */
static PetscErrorCode is_absent(const Model *m, const char *name, PetscBool *any, PetscBool *all)
{
  const PetscInt set = NameRow(m->mesh.n_face_sets, m->mesh.face_set_names, name),
                 point = NameRow(m->mesh.n_points, m->mesh.point_names, name);
  PetscInt n[2] = {0, 0}; // numbers of present and absent ones
  PetscFunctionBeginUser;
  for (PetscInt i = set < 0 ? 0 : m->mesh.face_set_start[set];
       set >= 0 && i < m->mesh.face_set_start[set + 1]; i++)
    n[m->materials.absent[m->faces.group[m->mesh.face_set_faces[i]]]]++;
  const PetscInt v = set < 0 && point >= 0 ? m->mesh.point_vertex[point] : -1;
  for (const Elements *e = m->mesh.elements; e < m->mesh.elements + ELEMENT_LISTS && v >= 0; e++)
    for (PetscInt i = 0; i < e->n; i++)
      for (int k = 0; k < e->n_nodes; k++)
        if (VertexOf(e, i, k) == v) n[m->materials.absent[e->group[i]]]++;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 2, MPIU_INT, MPI_SUM, m->comm));
  *all = (PetscBool)(n[1] && !n[0]);
  *any = set < 0 && point >= 0 ? *all : (PetscBool)(n[1] > 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether a load is water at rest, which stands at present blocks and spreads to blocks that are
   built later. */
static PetscBool stands_at_rest(LoadKind kind)
{
  return (PetscBool)(kind == LOAD_RESERVOIR || kind == LOAD_SILT || kind == LOAD_TAILWATER);
}

/* Collective. Refuses loads that act on blocks not built yet. Water at rest acts on present blocks only. */
static PetscErrorCode check_loads(const Scene *scene, const Stage *stage, const Model *m)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const Load *load = scene->loads + stage->loads[i];
    PetscBool any = PETSC_FALSE, all = PETSC_FALSE;
    if (load->kind == LOAD_DRAIN || load->kind == LOAD_CURTAIN || load->kind == LOAD_HEAD ||
        load->kind == LOAD_INFLOW)
      any = all = PETSC_TRUE; // joints of the network are absent
    else if (load->target[0] && load->kind != LOAD_TEMPERATURE)
      PetscCall(is_absent(m, load->target, &any, &all));
    if (load->surface.crest[0] && !any) PetscCall(is_absent(m, load->surface.crest, &any, &all));
    if (!(stands_at_rest(load->kind) ? all : any) || message[0]) continue;
    refuse(scene, stage, message, "loads.%s acts where groups are not built yet", load->name);
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses features that lifts cannot be combined with; the same on all ranks. */
static PetscErrorCode check_scene(const Scene *scene, const Model *m)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < scene->n_stages; s++) {
    const Stage *stage = scene->stages + s;
    for (PetscInt i = 0; i < stage->n_build; i++) {
      const PetscInt g = NameRow(m->materials.n_groups, m->materials.names, stage->build[i]);
      const char *why = scene->materials[g].condensed > 0
                            ? "is condensed: its factor is made once, with all that holds it"
                        : scene->materials[g].rigid ? "is rigid: only blocks that deform are placed"
                        : !PetscIsNanReal(scene->materials[g].k0)
                            ? "has k0: what is built is no ground at rest"
                        : built_in(scene, m, g, StageBase(scene, s)) >= 0 ? "is built twice"
                                                                          : NULL;
      if (why) refuse(scene, stage, message, "build: the group %s %s", stage->build[i], why);
    }
    if (stage->connectivity == CONNECTIVITY_VARIABLE)
      refuse(scene, stage, message,
             "connectivity is variable, and groups are built: expected fixed contacts");
    PetscBool whole = PETSC_TRUE;
    for (PetscInt g = 0; g < m->materials.n_groups; g++)
      whole = (PetscBool)(whole && (!m->lifts->built[g] || built_in(scene, m, g, s) >= 0));
    if (!whole && !StageRelaxes(stage))
      refuse(scene, stage, message, "groups are not built yet: expected a static stage, or one of trials");
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LiftsCreate(const Scene *scene, Model *m)
{
  Materials *materials = &m->materials;
  PetscInt n_build = 0;
  struct _p_Lifts *l;
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < scene->n_stages; s++) n_build += scene->stages[s].n_build;
  if (!n_build) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&l));
  m->lifts = l;
  l->n_stages = scene->n_stages;
  PetscCall(PetscMalloc4(materials->n_groups, &l->built, materials->n_groups, &l->lame, materials->n_groups,
                         &l->density, 3 * materials->n_groups, &l->hourglass));
  PetscCall(PetscCalloc2(materials->n_groups, &materials->absent, l->n_stages, &l->at));
  PetscCall(PetscArraycpy(l->lame, materials->lame, materials->n_groups));
  PetscCall(PetscArraycpy(l->density, materials->density, materials->n_groups));
  if (materials->hourglass)
    PetscCall(PetscArraycpy(l->hourglass, materials->hourglass, 3 * materials->n_groups));
  for (PetscInt g = 0; g < materials->n_groups; g++) {
    l->built[g] = PETSC_FALSE;
    for (PetscInt s = 0; s < scene->n_stages; s++)
      if (NameRow(scene->stages[s].n_build, scene->stages[s].build, materials->names[g]) >= 0)
        l->built[g] = PETSC_TRUE;
  }
  PetscCall(check_scene(scene, m));
  for (PetscInt s = scene->n_stages - 1; s >= 0; s--) { // leads back to the first stage
    Contacts contacts;
    PetscCall(set_present(scene, s, m));
    PetscCall(check_loads(scene, scene->stages + s, m));
    if (s && !scene->stages[s].n_build) continue;
    PetscCall(ContactsCreate(scene, m, &contacts));
    PetscCall(check_hanging(scene, scene->stages + s, m, &contacts));
    PetscCall(ContactsDestroy(&contacts));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LiftsDestroy(Model *m)
{
  struct _p_Lifts *l = m->lifts;
  PetscFunctionBeginUser;
  if (!l) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt s = 0; s < l->n_stages; s++) PetscCall(PetscFree(l->at[s]));
  PetscCall(PetscFree4(l->built, l->lame, l->density, l->hourglass));
  PetscCall(PetscFree2(m->materials.absent, l->at));
  PetscCall(PetscFree(m->lifts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- on the way */

/* Starts the written displacements from zero. Vertices that are not built yet have none. */
static PetscErrorCode reset(const Problem *p)
{
  PetscFunctionBeginUser;
  if (p->stage->displacements != DISPLACEMENTS_RESET) PetscFunctionReturn(PETSC_SUCCESS);
  if (!p->state->reset) PetscCall(PetscMalloc1(ModelApplied(p->m), &p->state->reset));
  PetscCall(PetscArraycpy(p->state->reset, p->state->u, ModelApplied(p->m)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LiftsPlace(const Problem *p)
{
  Model *m = p->m;
  struct _p_Lifts *l = m->lifts;
  const PetscReal *u = p->state->u + 3 * m->rigid.n;
  const PetscInt n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscFunctionBeginUser;
  if (p->state->lifts_stage >= p->number) PetscFunctionReturn(PETSC_SUCCESS);
  p->state->lifts_stage = p->number;
  PetscCall(reset(p));
  if (!l || !p->stage->n_build) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(n, &l->at[p->number]));
  PetscCall(PetscArraycpy(l->at[p->number], u, n));
  PetscCall(set_present(p->scene, p->number, m));
  PetscCall(count_strain(p->scene, m));
  PetscCall(ContactsPlace(p->scene, m, p->stage->joints, u, p->contacts));
  PetscCall(CondensedCheckContacts(p->scene, m, p->contacts));
  PetscCall(NewtonDestroy(&p->relax->newton)); // its factor and pattern belong to the model before
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LiftsArchive(Archive *a, const Scene *scene, Model *m, State *state)
{
  struct _p_Lifts *l = m->lifts;
  PetscInt stage = state->lifts_stage, has = state->reset != NULL;
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "begun", 1, &stage));
  PetscCall(ArchiveInts(a, "reset", 1, &has));
  stage = state->lifts_stage = (PetscInt)ArchiveWithin(a, "begun", stage, 0, scene->n_stages - 1);
  if (has && !state->reset) PetscCall(PetscCalloc1(ModelApplied(m), &state->reset));
  if (has) PetscCall(ArchiveApplied(a, m, "written_from", state->reset));
  for (PetscInt s = stage; s > 0 && l; s = StageBase(scene, s)) {
    char name[NAME_LENGTH];
    if (!scene->stages[s].n_build) continue;
    if (!l->at[s]) PetscCall(PetscCalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &l->at[s]));
    PetscCall(PetscSNPrintf(name, sizeof(name), "placed_%" PetscInt_FMT, s));
    PetscCall(ArchiveVertices(a, m, name, l->at[s]));
    if (!a->reading) continue;
    PetscCall(GhostBegin(m, l->at[s]));
    PetscCall(GhostEnd(m, l->at[s]));
  }
  if (!a->reading || !l) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(set_present(scene, stage, m));
  PetscCall(count_strain(scene, m));
  PetscFunctionReturn(PETSC_SUCCESS);
}
