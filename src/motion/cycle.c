/* cycle.c: one cycle. */
#include "stages/stages.h"

/* ---- what each part costs: PETSc events for -log_view, and by the clock for the reports of set-up and
   stages: a cycle's parts in one cycle of SAMPLE_EVERY, the others whole */

enum { SAMPLE_EVERY = 64 };
static const struct {
  const char *event, *words; /* words NULL: a part of another part */
} parts[PARTS] = {[PART_EXCHANGE] = {"GhostExchange", "exchange"},
                  [PART_CONTACTS] = {"ContactForces", "contacts"},
                  [PART_BLOCKS] = {"ElementForces", "blocks"},
                  [PART_RIGID] = {"RigidBodies", "rigid bodies"},
                  [PART_INTEGRATION] = {"Integrate", "integration"},
                  [PART_DAMPING] = {"Damping", "damping"},
                  [PART_REPARTITION] = {"Repartition", "re-partition"},
                  [PART_VERIFICATION] = {"Verification", "verification"},
                  [PART_FAR_FACES] = {"VerifyFarFaces", NULL},
                  [PART_NEAR_FACES] = {"VerifyNearFaces", NULL},
                  [PART_FACE_CONTACTS] = {"VerifyFaces", NULL},
                  [PART_VERTEX_CONTACTS] = {"VerifyVertices", NULL},
                  [PART_HISTORY] = {"VerifyHistory", NULL},
                  [PART_READING] = {"SetUpReading", "reading"},
                  [PART_CHECKS] = {"SetUpChecks", "checks"},
                  [PART_ORDER] = {"SetUpOrder", "order"},
                  [PART_PARTITION] = {"SetUpPartition", "partition"},
                  [PART_DISTRIBUTION] = {"SetUpDistribution", "distribution"},
                  [PART_MODEL] = {"SetUpModel", "model"},
                  [PART_FIRST_CONTACTS] = {"SetUpContacts", "contacts"},
                  [PART_OUTPUT_START] = {"SetUpOutput", "output"}};
static PetscLogEvent part_event[PARTS];
static double part_start[PARTS], part_time[PARTS], sampled_cycles;
static PetscBool part_registered = PETSC_FALSE, sampling = PETSC_FALSE;

PetscErrorCode PartBegin(Part part)
{
  PetscClassId id;
  PetscFunctionBeginUser;
  if (!part_registered) {
    PetscCall(PetscClassIdRegister("Quoin", &id));
    for (int p = 0; p < PARTS; p++) PetscCall(PetscLogEventRegister(parts[p].event, id, &part_event[p]));
    part_registered = PETSC_TRUE;
  }
  PetscCall(PetscLogEventBegin(part_event[part], 0, 0, 0, 0));
  if (sampling || part >= PART_REPARTITION) part_start[part] = MPI_Wtime();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PartEnd(Part part)
{
  PetscFunctionBeginUser;
  if (sampling || part >= PART_REPARTITION) part_time[part] += MPI_Wtime() - part_start[part];
  PetscCall(PetscLogEventEnd(part_event[part], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PartSample(PetscInt64 cycle)
{
  sampling = (PetscBool)(cycle % SAMPLE_EVERY == 0);
  sampled_cycles += sampling;
}

/* Shares of the parts first .. last, and forgets them. */
static PetscErrorCode print_shares(MPI_Comm comm, Part first, Part last, double sum)
{
  PetscFunctionBeginUser;
  for (Part p = first; p <= last; p++) {
    if (parts[p].words && part_time[p] > 0.005 * sum)
      PetscCall(PetscPrintf(comm, " %s %.0f %%", parts[p].words, 100. * part_time[p] / sum));
    part_time[p] = 0.;
  }
  PetscCall(PetscPrintf(comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PartReport(MPI_Comm comm, PetscInt64 cycles)
{
  double sum = part_time[PART_REPARTITION] + part_time[PART_VERIFICATION];
  PetscFunctionBeginUser;
  for (Part p = 0; p < PART_REPARTITION; p++) {
    part_time[p] *= sampled_cycles > 0. ? (double)cycles / sampled_cycles : 0.;
    sum += part_time[p];
  }
  if (sum > 0. && cycles) {
    PetscCall(PetscPrintf(comm, "  %.3g us a cycle:", 1e6 * sum / (double)cycles));
    PetscCall(print_shares(comm, 0, PART_VERIFICATION, sum));
  }
  sampled_cycles = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PartReportSetUp(MPI_Comm comm)
{
  double sum = 0.;
  PetscFunctionBeginUser;
  for (Part p = PART_READING; p < PARTS; p++) sum += part_time[p];
  PetscCall(PetscPrintf(comm, "set-up %.2f s:", sum));
  PetscCall(print_shares(comm, PART_READING, PARTS - 1, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* |contact force| per dof: what the unbalanced force of a body is compared with. f
   holds contact forces only. */
static void scale_of_contacts(const Model *m, const PetscReal *f, PetscReal *scale)
{
  const PetscReal *f_vertex = f + 3 * m->n_bodies;
  for (PetscInt d = 0; d < 2 * m->n_deformable; d++) scale[3 * m->n_bodies + d] = PetscAbsReal(f_vertex[d]);
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    scale[3 * b] = scale[3 * b + 1] = scale[3 * b + 2] = 0.;
    for (PetscInt v = m->body_start[b]; v < m->body_start[b + 1]; v++)
      for (int i = 0; i < 2; i++) scale[3 * b + i] += PetscAbsReal(f_vertex[2 * v + i]);
  }
}

/* f before forces are added to it; inner vertices of condensed bodies keep theirs. dofs: at
   degrees of freedom too. */
static void clear_forces(const Model *m, PetscBool dofs, PetscReal *f)
{
  PetscReal *f_vertex = f + 3 * m->n_bodies;
  if (dofs) memset(f, 0, m->n_dof * sizeof *f);
  memset(f_vertex + 2 * m->n_deformable, 0, 2 * (m->n_moving - m->n_deformable) * sizeof *f);
  memset(f_vertex + 2 * m->n_owned, 0, 2 * (m->n_vertices - m->n_owned + DUMMY_VERTICES) * sizeof *f);
}

/* The forces of contacts, which come first at every vertex. keep: the contacts' arrays of the last
   evaluation are written as well. */
static PetscErrorCode contact_forces(const Model *m, const Joint *joints, Contacts *contacts, State *state,
                                     PetscBool keep, PetscReal *contact_scale)
{
  const PetscInt at = 3 * m->n_bodies;
  PetscFunctionBeginUser;
  PetscCall(PartBegin(PART_CONTACTS));
  if (keep)
    PetscCall(ContactForces(m, joints, contacts, state->u + at, state->f + at)); // (1)-(6)
  else
    PetscCall(ContactForcesOnly(m, joints, contacts, state->u + at, state->f + at));
  PetscCall(PartEnd(PART_CONTACTS));
  if (contact_scale) scale_of_contacts(m, state->f, contact_scale);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Forces(const Model *m, const Joint *joints, Contacts *contacts, State *state,
                      PetscReal *contact_scale)
{
  const PetscInt at = 3 * m->n_bodies;
  PetscFunctionBeginUser;
  // what the other ranks' vertices did
  PetscCall(PartBegin(PART_EXCHANGE));
  PetscCall(GhostBegin(m, state->u + at));
  clear_forces(m, PETSC_TRUE, state->f);
  PetscCall(GhostEnd(m, state->u + at));
  PetscCall(PartEnd(PART_EXCHANGE));
  PetscCall(contact_forces(m, joints, contacts, state, PETSC_TRUE, contact_scale));
  PetscCall(PartBegin(PART_BLOCKS));
  CondensedForces(m, state->u + at, state->f + at);
  PetscCall(ElementForces(m, state->u + at, state->f + at)); // (10)
  PetscCall(PartEnd(PART_BLOCKS));
  PetscCall(PartBegin(PART_RIGID));
  RigidForces(m, state->u, state->f); // (15)
  PetscCall(PartEnd(PART_RIGID));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forces of deformable blocks, chunk by chunk, and the motion of vertices whose forces are complete:
   no later block reads their displacement. Even numbers of vertices, so that only the last sweep
   ends within a vector. */
static void move_vertices(const Model *m, State *state, const QuotientSums *last, QuotientSums *sums)
{
  const PetscInt at = 3 * m->n_bodies;
  PetscInt moved = 0;
  for (PetscInt chunk = 0; chunk < ElementChunks(m); chunk++) {
    const PetscInt done = m->chunk_done[chunk] / 2 * 2, from = at + 2 * moved, to = at + 2 * done;
    const Ahead ahead = IntegrateAhead(state, from);
    ElementForcesOfChunk(m, chunk, &ahead, state->u + at, state->f + at); // (10)
    IntegrateRange(m, state, last, from, to, sums);                       // (11)-(20)
    moved = done;
  }
  IntegrateRange(m, state, last, at + 2 * moved, at + 2 * m->n_deformable, sums);
}

/* What ranks tell each other at the end of a cycle, all of it before they wait for any: who comes last
   finds everything there. */
static PetscErrorCode exchange(const Scene *scene, const Model *m, State *state, Relaxation *relax,
                               const QuotientSums *local)
{
  PetscReal *u = state->u + 3 * m->n_bodies;
  PetscFunctionBeginUser;
  PetscCall(PartBegin(PART_EXCHANGE));
  DampingBegin(scene, m, relax, local);
  PetscCall(GhostBegin(m, u));
  PetscCall(PartEnd(PART_EXCHANGE));
  PetscCall(PartBegin(PART_DAMPING));
  PetscCall(DampingEnd(scene, m, state, relax)); // (35)-(38), for the next cycle
  PetscCall(PartEnd(PART_DAMPING));
  PetscCall(PartBegin(PART_EXCHANGE));
  PetscCall(GhostEnd(m, u));
  PetscCall(PartEnd(PART_EXCHANGE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Step(const Scene *scene, const Model *m, const Joint *joints, Contacts *contacts, State *state,
                    Relaxation *relax, PetscReal *contact_scale)
{
  const PetscBool clear = state->f_old_clear; // since the cycle before
  PetscReal *swap = state->f_old;
  QuotientSums local = {{0., 0.}, {0., 0.}, 0., 0.};
  PetscFunctionBeginUser;
  PartSample(state->cycle);
  state->local = scene->damping == DAMPING_LOCAL ? scene->local : 0.;
  state->f_old = state->f;
  state->f = swap;
  state->f_old_clear = PETSC_FALSE;
  clear_forces(m, (PetscBool)!clear, state->f);
  PetscCall(contact_forces(m, joints, contacts, state, (PetscBool)(contact_scale != NULL), contact_scale));
  PetscCall(PartBegin(PART_BLOCKS));
  CondensedForces(m, state->u + 3 * m->n_bodies, state->f + 3 * m->n_bodies);
  move_vertices(m, state, &relax->sums, &local);
  PetscCall(PartEnd(PART_BLOCKS));
  PetscCall(PartBegin(PART_RIGID));
  RigidForces(m, state->u, state->f);                                 // (15)
  IntegrateRange(m, state, &relax->sums, 0, 3 * m->n_bodies, &local); // (11)-(20)
  state->f_old_clear = PETSC_TRUE;
  RigidMotion(m, state->u); // (21)-(22)
  PetscCall(PartEnd(PART_RIGID));
  PetscCall(exchange(scene, m, state, relax, &local));
  state->cycle++;
  PetscFunctionReturn(PETSC_SUCCESS);
}
