/* fields.c: gathers the results of the ranks on rank 0, in file order (contacts: by their faces in file
   order). All output and all sums for users go through here, so they have the same bits on any number of
   ranks. */
#include "result/result.h"
#include <stdlib.h>

enum { BLOCK_ROW = 9 };

/* Fills rows with file id, gid, group, macroblock, vertices and rank of the owned elements of one list. */
static void block_rows(const Model *model, const Elements *e, PetscInt *n, PetscInt (*rows)[BLOCK_ROW])
{
  for (PetscInt i = 0; i < e->n; i++) {
    if (!e->owned[i]) continue;
    PetscInt *row = rows[(*n)++];
    row[0] = e->file[i];
    row[1] = e->gid[i];
    row[2] = e->group[i];
    row[3] = model->mesh.vertex_body[VertexOf(e, i, 0)];
    for (int k = 0; k < 4; k++) row[4 + k] = k < e->n_nodes ? model->mesh.vertex_file[VertexOf(e, i, k)] : -1;
    row[8] = model->rank;
  }
}

PetscErrorCode GatherVertices(const Model *m, PetscInt width, const PetscReal *values, PetscReal **all)
{
  PetscFunctionBeginUser;
  PetscCall(GatherPlaced(m->comm, m->mesh.n_owned, m->mesh.vertex_file, width * sizeof(*values), values,
                         m->mesh.n_vertices_global, all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherMesh(const Model *model, MeshFields *mesh)
{
  PetscInt n = 0, n_all, most = 1, (*rows)[BLOCK_ROW], (*all)[BLOCK_ROW];
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(mesh, sizeof(*mesh)));
  mesh->n_vertices = model->mesh.n_vertices_global;
  mesh->n_blocks = model->mesh.n_blocks_global;
  PetscCall(GatherVertices(model, 2, model->mesh.X, &mesh->X));
  for (int l = 0; l < ELEMENT_LISTS; l++) most += model->mesh.elements[l].n;
  PetscCall(PetscMalloc(most * sizeof(*rows), &rows));
  for (int l = 0; l < ELEMENT_LISTS; l++) block_rows(model, model->mesh.elements + l, &n, rows);
  PetscCall(GatherAndFree(model->comm, n, sizeof(*rows), rows, &n_all, (void **)&all));
  if (model->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc5(4 * n_all, &mesh->blocks, n_all, &mesh->group, n_all, &mesh->macroblock, n_all,
                         &mesh->rank, n_all, &mesh->file));
  for (PetscInt i = 0; i < n_all; i++) {
    const PetscInt *row = all[i], b = row[0];
    mesh->file[row[1]] = b;
    mesh->group[b] = row[2];
    mesh->macroblock[b] = row[3];
    mesh->rank[b] = row[8];
    PetscCall(PetscArraycpy(mesh->blocks + 4 * b, row + 4, 4));
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherMeshDestroy(MeshFields *mesh)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(mesh->X));
  PetscCall(PetscFree5(mesh->blocks, mesh->group, mesh->macroblock, mesh->rank, mesh->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers displacement, reaction of supports, applied force and supports of the owned vertices. */
static PetscErrorCode gather_motion(const Model *model, const State *state, StageFields *s)
{
  const PetscInt n = model->mesh.n_owned, first = 3 * model->rigid.n;
  VertexRow *rows;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(PetscMax(1, n), &rows));
  for (PetscInt i = 0; i < n; i++) {
    VertexRow *row = rows + i;
    for (int x = 0; x < 2; x++) {
      const PetscInt dof = first + 2 * i + x;
      row->u[x] = Shown(state, dof);
      row->support[x] = -1;
      if (i >= model->mesh.n_deformable && i < model->mesh.n_moving) continue;
      if (Held(model, dof)) row->reaction[x] = state->f[dof] - state->f_ext[dof];
      if (Held(model, dof) && state->inertial && dof < model->n_dof) row->reaction[x] += state->inertial[dof];
      row->support[x] = SupportRow(model, dof);
      row->applied[x] = state->f_ext[dof] + (state->passed ? state->passed[dof] : 0.);
    }
  }
  PetscCall(GatherPlaced(model->comm, n, model->mesh.vertex_file, sizeof(*rows), rows,
                         model->mesh.n_vertices_global, &s->vertex));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers the same for the rigid bodies, about their centroids. */
static PetscErrorCode gather_bodies(const Model *model, const State *state, StageFields *s)
{
  BodyRow *rows;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(PetscMax(1, model->rigid.n), &rows));
  for (PetscInt i = 0; i < model->rigid.n; i++) {
    for (int x = 0; x < 3; x++) {
      const PetscInt dof = 3 * i + x;
      rows[i].u[x] = Shown(state, dof);
      if (Held(model, dof)) rows[i].reaction[x] = state->f[dof] - state->f_ext[dof];
      if (x < 2) rows[i].support[x] = SupportRow(model, dof);
      rows[i].applied[x] = state->f_ext[dof] + (state->passed ? state->passed[dof] : 0.);
    }
  }
  s->n_bodies = model->mesh.n_rigid_global;
  PetscCall(GatherPlaced(model->comm, model->rigid.n, model->rigid.gid, sizeof(*rows), rows, s->n_bodies,
                         &s->body));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns a row without values. */
static BlockRow empty_row(void)
{
  BlockRow row;
  PetscReal *value = (PetscReal *)&row;
  for (size_t k = 0; k < sizeof(row) / sizeof(*value); k++) value[k] = NAN;
  return row;
}

/* Fills in the results of a material law that is not elastic. */
static void law_results(MaterialLaw law, const LawReported *reported, BlockRow *row)
{
  row->measure[law - 1] = reported->measure;
  row->lost = reported->lost;
  if (reported->opening >= 0.) row->crack_width = reported->opening;
}

/* Computes stress and energy of one list of deformable elements. */
static PetscErrorCode element_rows(const Model *model, const Elements *e, int n_nodes, const State *state,
                                   PetscInt *n, PetscInt *place, BlockRow *rows)
{
  const TermView view = {.m = model, .state = state};
  const PetscReal *u = state->u + 3 * model->rigid.n;
  const PetscInt n_gauss = n_nodes == 4 ? 4 : 1;
  PetscReal *centre, *gauss, *energy, *change, *across;
  LawReported *reported = NULL;
  PetscFunctionBeginUser;
  if (e->history) {
    PetscCall(PetscMalloc1(e->n, &reported));
    LawReport(model, e, u, reported);
  }
  PetscCall(PetscMalloc3(3 * e->n_padded, &centre, 3 * n_gauss * e->n_padded, &gauss, e->n_padded, &energy));
  PetscCall(PetscCalloc2(e->n_padded, &change, e->n_padded, &across));
  PetscCall(ElementStress(model, e, n_nodes, u, centre));
  PetscCall(ElementStressGauss(model, e, n_nodes, u, gauss));
  PetscCall(ElementEnergy(model, e, n_nodes, u, energy));
  PetscCall(TermsOfBlocks(&view, e, &(BlockAnswers){centre, gauss, energy, change, across}));
  for (PetscInt i = 0; i < e->n; i++) {
    if (!e->owned[i]) continue;
    BlockRow *row = rows + *n;
    const Lame *lame = model->materials.lame + e->group[i];
    place[(*n)++] = e->file[i];
    *row = empty_row();
    row->energy = 0., row->built = !(model->materials.absent && model->materials.absent[e->group[i]]);
    if (reported) law_results(e->law, reported + i, row);
    if (!(row->built > 0.)) continue;
    for (int k = 0; k < 3; k++) row->stress[k] = centre[3 * i + k];
    PetscReal principal[2];
    PrincipalStress(row->stress, principal, &row->angle);
    row->s1 = principal[0], row->s2 = principal[1];
    row->energy = energy[i];
    for (int k = 0; k < 3 * n_gauss; k++) row->gauss[k / 3][k % 3] = gauss[3 * n_gauss * i + k];
    row->warmer = change[i];
    if (e->law == MATERIAL_ELASTIC)
      row->stress_z = 0.5 * lame->lambda / (lame->lambda + lame->mu) * (row->stress[0] + row->stress[1]) +
                      across[i];
  }
  PetscCall(PetscFree(reported));
  PetscCall(PetscFree3(centre, gauss, energy));
  PetscCall(PetscFree2(change, across));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the rotation of one list of rigid blocks. body_of: body of each owned rigid vertex, from vertex
   n_deformable on. */
static void rigid_rows(const Model *model, const State *state, const Elements *e, const PetscInt *body_of,
                       PetscInt *n, PetscInt *place, BlockRow *rows)
{
  for (PetscInt i = 0; i < e->n; i++) {
    if (!e->owned[i]) continue;
    BlockRow *row = rows + *n;
    const PetscInt vertex = VertexOf(e, i, 0);
    place[(*n)++] = e->file[i];
    *row = empty_row();
    row->energy = 0., row->built = 1.;
    row->rotation = state->u[3 * body_of[vertex - model->mesh.n_deformable] + 2];
  }
}

static PetscErrorCode gather_blocks(const Model *model, const State *state, StageFields *s)
{
  PetscInt n = 0, most = 1, *place, *body_of;
  BlockRow *rows;
  PetscFunctionBeginUser;
  for (int l = 0; l < ELEMENT_LISTS; l++) most += model->mesh.elements[l].n;
  PetscCall(PetscMalloc1(most, &place));
  PetscCall(PetscMalloc1(most, &rows));
  PetscCall(PetscMalloc1(1 + model->mesh.n_moving - model->mesh.n_deformable, &body_of));
  for (PetscInt i = 0; i < model->rigid.n; i++) {
    for (PetscInt v = model->rigid.start[i]; v < model->rigid.start[i + 1]; v++)
      body_of[v - model->mesh.n_deformable] = i;
  }
  PetscCall(element_rows(model, &model->mesh.t3, 3, state, &n, place, rows));
  PetscCall(element_rows(model, &model->mesh.q4, 4, state, &n, place, rows));
  for (const Elements *e = model->mesh.elements + ELASTIC_LISTS; e < model->mesh.elements + DEFORMABLE_LISTS;
       e++)
    PetscCall(element_rows(model, e, e->n_nodes, state, &n, place, rows));
  PetscCall(element_rows(model, &model->mesh.condensed_t3, 3, state, &n, place, rows));
  PetscCall(element_rows(model, &model->mesh.condensed_q4, 4, state, &n, place, rows));
  rigid_rows(model, state, &model->mesh.rigid_t3, body_of, &n, place, rows);
  rigid_rows(model, state, &model->mesh.rigid_q4, body_of, &n, place, rows);
  PetscCall(PetscFree(body_of));
  PetscCall(GatherPlaced(model->comm, n, place, sizeof(*rows), rows, model->mesh.n_blocks_global, &s->block));
  PetscCall(PetscFree(place));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the fraction [-] of a contact that is open: where the linear opening between its ends is
   positive. */
static PetscReal open_fraction(const ContactRow *c)
{
  const int open[2] = {!!(c->end[0].state & CONTACT_OPEN), !!(c->end[1].state & CONTACT_OPEN)};
  if (open[0] == open[1]) return open[0];
  const PetscReal in = c->end[open[1]].opening,
                  out = c->end[open[0]].opening; // opening at the open end, at the closed end
  return in > 0 && out < 0 ? in / (in - out) : 0.5;
}

/* Decides whether the diagram of tptm, and not the openings, gives the open part of a contact: where the
   joint was crushed or carries tension. */
static PetscBool has_diagram(StressModelKind kind, const Joint *joint, PetscReal closure_0,
                             PetscReal closure_1)
{
  const PetscBool crushed = (PetscBool)(closure_0 < 0. || closure_1 < 0.),
                  tensile = (PetscBool)(joint->law != LAW_ELASTIC && joint->tension[0] > 0.);
  return (PetscBool)(kind == STRESS_TPTM && (crushed || tensile));
}

/* Computes the lengths of a contact that are open and crushing. */
static void contact_lengths(StressModelKind kind, const Joint *joint, const ContactPoint *p, ContactRow *row)
{
  PetscReal open = open_fraction(row), crushing = 0.;
  for (int k = 0; k < 2; k++) crushing += 0.5 * !!(row->end[k].state & CONTACT_CRUSHING);
  if (has_diagram(kind, joint, p->closure[0], p->closure[1]) && row->klass != VERTEX_FACE)
    StressModelParts(joint, p, &open, &crushing);
  row->open = row->length * open, row->crushing = row->length * crushing;
}

/* Computes the end forces [N] of a contact from its stored opening, slip and history, without changing
   them. */
static void contact_end_forces(const Contacts *c, PetscInt i, StressModelKind kind, const Joint *joint,
                               PetscReal thickness, ContactPoint *p, ContactRow *row)
{
  *p = (ContactPoint){.margin = c->margin,
                      .in_time = (PetscBool)(c->rate != 0. || c->friction == FRICTION_SPRINGS)};
  for (int k = 0; k < 2; k++) {
    const PetscInt j = SUB(i, k);
    p->u_n[k] = c->u_n[j];
    p->u_s[k] = c->u_s[j];
    p->slip[k] = c->slip[j];
    p->broken[k] = c->broken[j];
    p->closure[k] = c->closure[j], p->closure_far[k] = c->closure_far[j];
  }
  StressModelRespond(kind, joint, c->length[i], p);
  for (int k = 0; k < 2; k++) {
    row->end[k].opening = p->u_n[k];
    row->end[k].closure = StressModelClosure(p, k);
    row->end[k].force[0] = thickness * p->F_n[k];
    row->end[k].force[1] = thickness * p->F_s[k];
  }
}

/* Finds where end k of contact i is, and the normal from side b to side a. The outward normal of the
   destination leads from the destination to the vertex. Turning it round leaves F_n and F_s as they are,
   because then they act on the other side. */
static void contact_end_place(const Model *model, const PetscReal *u, const Contacts *c, PetscInt i, int k,
                              ContactEnd *end)
{
  const PetscReal moving = model->materials.strain == STRAIN_LARGE ? 1 : 0;
  PetscInt v[3];
  PetscReal along[2];
  ContactEndVertices(c, i, k, v);
  const PetscInt P = v[0], A = v[1], B = v[2];
  for (int x = 0; x < 2; x++) {
    end->point[x] = model->mesh.X[2 * P + x];
    end->displacement[x] = u[2 * P + x];
    along[x] = model->mesh.X[2 * B + x] - model->mesh.X[2 * A + x] + moving * (u[2 * B + x] - u[2 * A + x]);
  }
  const PetscReal length = PetscSqrtReal(along[0] * along[0] + along[1] * along[1]);
  const PetscReal from_b = ContactSideOfVertex(c, i, k) ? -1 : 1;
  end->normal[0] = from_b * along[1] / length;
  end->normal[1] = -from_b * along[0] / length;
}

void ContactNormal(const Model *model, const PetscReal *u, const Contacts *c, PetscInt i, int k,
                   PetscReal n[2])
{
  ContactEnd end;
  contact_end_place(model, u, c, i, k, &end);
  n[0] = end.normal[0], n[1] = end.normal[1];
}

static PetscReal distance(const Model *model, PetscInt v, PetscInt w)
{
  return PetscHypotReal(model->mesh.X[2 * v] - model->mesh.X[2 * w],
                        model->mesh.X[2 * v + 1] - model->mesh.X[2 * w + 1]);
}

/* Returns the length of a contact over its control length, at most 1; the control length is a tenth of the
   shorter face. A shorter contact is new, left over where blocks have slid, or a corner, so its stress is no
   stress of a face. */
static PetscReal control_part(const Model *model, const Contacts *c, PetscInt i, PetscReal length)
{
  PetscInt v[CONTACT_ROWS];
  for (int r = 0; r < CONTACT_ROWS; r++) v[r] = c->vertex[CONTACT_ROW(i, r)];
  PetscReal face = distance(model, v[ROW_A], v[ROW_B]);
  if (c->klass[i] != VERTEX_FACE) face = PetscMin(face, distance(model, v[ROW_P], v[ROW_Q]));
  return PetscMin(1., length / (0.1 * face));
}

/* Decides whether a closed end carries all possible shear. The flag of the law belongs to the last
   evaluation: a slip committed since then leaves tau at the limit, or a rounding error below it. */
static PetscBool at_shear_limit(const Joint *joint, const ContactRow *row, int k)
{
  const ContactEnd *end = &row->end[k];
  const PetscReal limit = JointLimitAt(joint, end->broken, row->end[1 - k].broken, end->sigma);
  return (PetscBool)(!(end->state & CONTACT_OPEN) && PetscAbsReal(end->tau) > (1. - 1e-6) * limit);
}

/* Puts all the force of a vertex on a face at end 0, with the length for which N is sigma times the length.
   This is half the length of the point model, which gives two ends as much; with tptm it is the closed part
   of the diagram. */
static void one_end(const Model *model, const Contacts *c, PetscInt i, ContactRow *row)
{
  const PetscReal N = row->end[0].force[0] + row->end[1].force[0], sigma = row->end[0].sigma;
  const PetscBool moving = (PetscBool)(i >= c->model_start[STRESS_TPTM]);
  row->face[1] = -2 - model->mesh.vertex_file[c->vertex[CONTACT_ROW(i, ROW_P)]];
  row->body[1] = model->mesh.vertex_body[c->vertex[CONTACT_ROW(i, ROW_P)]];
  row->length = moving && sigma < 0. ? N / (model->materials.thickness * sigma)
                                     : (moving ? 1. : 0.5) * row->length;
  for (int x = 0; x < 2; x++) row->end[0].force[x] += row->end[1].force[x];
  row->end[1] = row->end[0];
  row->end[1].force[0] = row->end[1].force[1] = 0;
}

static void contact_row(const Model *model, const State *state, const Contacts *c, PetscInt i,
                        StressModelKind kind, const Joint *joints, ContactRow *row)
{
  ContactPoint p;
  row->face[0] = c->key[2 * i];
  row->face[1] = c->key[2 * i + 1];
  row->klass = c->klass[i];
  row->joint = c->joint[i];
  row->length = c->length[i];
  for (int k = 0; k < 2; k++) {
    const PetscInt j = SUB(i, k);
    ContactEnd *end = &row->end[k];
    contact_end_place(model, state->u + 3 * model->rigid.n, c, i, k, end);
    end->sliding = c->u_s[j];
    end->slip = c->slip[j];
    end->broken = PetscMin(1., c->broken[j]);
    end->sigma = c->sigma[j];
    end->tau = c->tau[j];
    end->state = c->state[j];
  }
  for (int k = 0; k < 2; k++)
    if (at_shear_limit(&joints[c->joint[i]], row, k)) row->end[k].state |= CONTACT_SLIPPING;
  contact_end_forces(c, i, kind, &joints[c->joint[i]], model->materials.thickness, &p, row);
  if (row->klass == VERTEX_FACE) one_end(model, c, i, row);
  row->control = control_part(model, c, i, row->length);
  contact_lengths(kind, &joints[c->joint[i]], &p, row);
}

/* Computes the length of a contact and its open length, without a row where both ends are open or closed:
   most contacts. */
void ContactLengths(const Problem *p, PetscInt i, StressModelKind kind, PetscReal *length, PetscReal *open)
{
  const Contacts *c = p->contacts;
  const Joint *joint = p->stage->joints + c->joint[i];
  ContactRow row;
  if (c->klass[i] == VERTEX_FACE || has_diagram(kind, joint, c->closure[SUB(i, 0)], c->closure[SUB(i, 1)])) {
    contact_row(p->m, p->state, c, i, kind, p->stage->joints, &row);
    *length = row.length, *open = row.open;
    return;
  }
  for (int k = 0; k < 2; k++) row.end[k].state = c->state[SUB(i, k)], row.end[k].opening = c->u_n[SUB(i, k)];
  *length = c->length[i], *open = *length * open_fraction(&row);
}

/* Collective. Finds the origin of the displacements of all vertices, NULL: 0. */
static PetscErrorCode reset_of_vertices(const Model *m, const State *state, PetscReal **reset)
{
  PetscFunctionBeginUser;
  *reset = NULL;
  if (!state->reset) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), reset));
  PetscCall(PetscArraycpy(*reset, state->reset + 3 * m->rigid.n, 2 * m->mesh.n_owned));
  PetscCall(GhostBegin(m, *reset));
  PetscCall(GhostEnd(m, *reset));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void count_from(const Contacts *c, PetscInt i, const PetscReal *reset, ContactRow *row)
{
  for (int k = 0; k < 2 && reset; k++) {
    PetscInt v[3];
    ContactEndVertices(c, i, row->klass == VERTEX_FACE ? 0 : k, v);
    for (int x = 0; x < 2; x++) row->end[k].displacement[x] -= reset[2 * v[0] + x];
  }
}

PetscErrorCode GatherContacts(const Model *model, const State *state, const Contacts *c, const Stage *stage,
                              const MeshFields *mesh, StageFields *s)
{
  PetscInt n = 0;
  ContactRow *rows;
  PetscReal *reset;
  PetscFunctionBeginUser;
  PetscCall(reset_of_vertices(model, state, &reset));
  PetscCall(PetscCalloc1(PetscMax(1, c->n), &rows));
  for (int kind = 0; kind < STRESS_MODELS; kind++) {
    for (PetscInt i = c->model_start[kind]; i < c->model_start[kind + 1]; i++) {
      if (c->key[2 * i] < 0 || !c->owned[i]) continue;
      contact_row(model, state, c, i, (StressModelKind)kind, stage->joints, &rows[n]);
      count_from(c, i, reset, &rows[n++]);
    }
  }
  PetscCall(GatherAndFree(model->comm, n, sizeof(*rows), rows, &s->n_contacts, (void **)&s->contact));
  PetscCall(PetscFree(reset));
  for (PetscInt i = 0; i < s->n_contacts; i++) {
    s->contact[i].gathered = i;
    for (int k = 0; k < 2; k++) {
      const PetscInt face = s->contact[i].face[k];
      if (face < 0) continue;
      s->contact[i].face[k] = 4 * mesh->file[face / 4] + face % 4;
      s->contact[i].body[k] = mesh->macroblock[mesh->file[face / 4]];
    }
  }
  if (s->n_contacts) qsort(s->contact, s->n_contacts, sizeof(ContactRow), OrderByPair);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherStage(const Model *model, const State *state, const Contacts *contacts,
                           const Stage *stage, const MeshFields *mesh, StageFields *s)
{
  PetscInt counts[2] = {model->n_dof, 0};
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(s, sizeof(*s)));
  PetscCall(gather_motion(model, state, s));
  PetscCall(gather_bodies(model, state, s));
  PetscCall(gather_blocks(model, state, s));
  PetscCall(GatherContacts(model, state, contacts, stage, mesh, s));
  s->time = state->time;
  PetscCallMPI(MPI_Reduce(counts, &s->n_dof, 1, MPIU_INT, MPI_SUM, 0, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherStageDestroy(StageFields *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(s->safety));
  PetscCall(PetscFree(s->safety_mode));
  PetscCall(PetscFree(s->mechanism));
  PetscCall(PetscFree(s->modes));
  PetscCall(PetscFree(s->envelope_block));
  PetscCall(PetscFree(s->envelope_contact));
  PetscCall(PetscFree(s->vertex));
  PetscCall(PetscFree(s->body));
  PetscCall(PetscFree(s->block));
  PetscCall(PetscFree(s->contact));
  PetscFunctionReturn(PETSC_SUCCESS);
}
