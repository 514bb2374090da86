/* vibration.c: finds small free vibrations about the present state, K phi = omega^2 M phi.

   K is the tangent of the state: open contacts stay open, closed contacts stick (tangent.c: small_tangent).
   In large strain K belongs to the present places of bodies, and includes the effect of their rotation
   under the forces they carry. M has the masses of a dynamic stage: of blocks at vertices and rigid bodies,
   and the water that the loads of the stage add (coupled_inertia.c). Supports hold the same degrees of
   freedom as in static stages.

   With b = M r, where r moves all mass with the ground along x or y, a shape has the modal mass m = phi.M
   phi, the participation factor phi.b/m and the effective mass (phi.b)^2/m. The effective masses of all
   modes add up to the mass that can move, r.b. */
#include "base/eigen.h"
#include "base/memory.h"
#include "solve/stiffness.h"
#include "solve/vibration.h"

static const PetscReal EQUAL = 1e-6; /* components of a shape that differ by less are of equal size */

/* ---- contacts */

/* Collective. Copies the contacts into `now`, evaluates their present forces, and counts them. counts: all
   contacts, open ones, slipping ones. */
static PetscErrorCode copy_contacts(const Problem *p, Contacts *now, PetscInt counts[3])
{
  Instant at = InstantOf(p);
  PetscReal *f;
  PetscFunctionBeginUser;
  PetscCall(ContactsCopy(p->contacts, now));
  now->friction = now->friction == FRICTION_SPRINGS || now->rate != 0. ? FRICTION_SPRINGS : FRICTION_KEPT;
  now->rate = 0.;
  at.contacts = now, at.results = PETSC_TRUE;
  PetscCall(PetscCalloc1(2 * (p->m->mesh.n_vertices + DUMMY_VERTICES), &f));
  PetscCall(TermsForces(PHASE_JOINTS, p->state, &at, f));
  PetscCall(PetscFree(f));
  counts[0] = counts[1] = counts[2] = 0;
  for (PetscInt i = 0; i < now->n_padded; i++) {
    if (now->key[2 * i] < 0 || !now->owned[i]) continue;
    int bits = 0;
    for (int k = 0; k < ContactEnds(now, i); k++)
      if (!ContactTouches(now, i, k)) bits |= now->state[SUB(i, k)];
    counts[0]++, counts[1] += !!(bits & CONTACT_OPEN), counts[2] += !!(bits & CONTACT_SLIPPING);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 3, MPIU_INT, MPI_SUM, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- mass */

/* Adds the added mass [kg] of water at one point to M and to the pull. The directions of the ground are the
   first two degrees of freedom of a vertex and of a rigid body. */
static PetscErrorCode add_water(PetscInt dof, PetscInt n, const PetscReal (*mass)[3], void *context)
{
  const Mass *to = context;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) {
    if (Held(to->m, dof + i)) continue;
    for (int x = 0; x < 2; x++) to->pull[x * to->rows + dof + i] += mass[i][x];
    for (PetscInt j = 0; j < n; j++)
      if (!Held(to->m, dof + j))
        PetscCall(MatSetValue(to->M, to->first + dof + i, to->first + dof + j, mass[i][j], ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Refuses a degree of freedom without mass, and a model in which nothing can move. */
static PetscErrorCode check_masses(const Problem *p)
{
  const Model *m = p->m;
  const PetscInt at = 3 * m->rigid.n;
  char message[MESSAGE_LENGTH] = "";
  PetscInt n_free = 0;
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < m->n_dof; d++) {
    if (Held(m, d)) continue;
    n_free++;
    if (DofMass(m, d) > 0. || message[0]) continue;
    const PetscInt v = d < at ? m->rigid.start[d / 3] : (d - at) / 2;
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: stages.%s: vertex %" PetscInt_FMT
                            " has no mass: modes need density > 0 in every group that is not held",
                            p->scene->file, p->stage->name, m->mesh.vertex_file[v]));
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n_free, 1, MPIU_INT, MPI_SUM, m->comm));
  if (!n_free)
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: stages.%s: supports hold everything: nothing swings", p->scene->file,
                            p->stage->name));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes M with the lumped masses [kg, kg m2], and their pull. */
static PetscErrorCode lump(Mass *mass)
{
  const Model *m = mass->m;
  PetscInt *diagonal;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(mass->rows, &diagonal));
  for (PetscInt i = 0; i < mass->rows; i++) diagonal[i] = 3;
  PetscCall(InsideRoom(m, diagonal));
  PetscCall(MatCreateAIJ(m->comm, mass->rows, mass->rows, PETSC_DETERMINE, PETSC_DETERMINE, 0, diagonal, 0,
                         NULL, &mass->M));
  PetscCall(PetscFree(diagonal));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal own = Held(m, d) ? 0. : DofMass(m, d);
    PetscCall(MatSetValue(mass->M, mass->first + d, mass->first + d, own, ADD_VALUES));
    for (int x = 0; x < 2; x++)
      mass->pull[x * mass->rows + d] = own * DofGround(m, d, (const PetscReal[2]){x == 0, x == 1});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the mass, with the rows of K. moving: (2,) [kg] mass that can move along x and y. */
static PetscErrorCode mass_create(const Problem *p, Mat K, Mass *mass, PetscReal moving[2])
{
  const Model *m = p->m;
  const TermView view = ViewOf(p);
  CoupledInertia *local;
  PetscFunctionBeginUser;
  *mass = (Mass){.m = m, .rows = m->n_dof + m->condensed.n_modes};
  PetscCall(MatGetOwnershipRange(K, &mass->first, NULL));
  PetscCall(PetscCalloc1(2 * mass->rows, &mass->pull));
  PetscCall(lump(mass));
  PetscCall(CoupledCreate(&view, NULL, &local));
  PetscCall(CoupledMasses(local, add_water, mass));
  PetscCall(CoupledDestroy(&local));
  moving[0] = moving[1] = 0.;
  for (int x = 0; x < 2; x++)
    for (PetscInt d = 0; d < m->n_dof; d++)
      moving[x] += mass->pull[x * mass->rows + d] * DofGround(m, d, (const PetscReal[2]){x == 0, x == 1});
  PetscCall(InsideMass(mass, moving));
  PetscCall(MatAssemblyBegin(mass->M, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(mass->M, MAT_FINAL_ASSEMBLY));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, moving, 2, MPIU_REAL, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- shapes */

/* Computes the displacements u (vertex array) [-] of all vertices of this rank by a shape phi (rows,). */
static PetscErrorCode find_shape(const Model *m, const Stiffness *s, const PetscReal *phi, PetscReal *u)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(u, 2 * (m->mesh.n_vertices + DUMMY_VERTICES)));
  for (PetscInt v = 0; v < m->mesh.n_moving; v++)
    for (int x = 0; x < 2; x++) {
      const PetscReal *body = v < m->mesh.n_deformable ? NULL : phi + 3 * RigidOfVertex(m, v);
      const PetscReal arm = x ? s->arm[2 * v] : -s->arm[2 * v + 1];
      u[2 * v + x] = body ? body[x] + body[2] * arm : phi[3 * m->rigid.n + 2 * v + x];
    }
  PetscCall(InsideShape(m, phi, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the scale by which a shape is divided: its largest displacement, with its sign. Of
   several of equal size the first vertex of model.h5 decides, so the sign is the same on any number of
   ranks. */
static PetscErrorCode scale_of(const Model *m, const PetscReal *u, PetscReal *scale)
{
  PetscReal most = 0.;
  PetscInt first = PETSC_MAX_INT; // 2 (2 vertex + x) + sign
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d++) most = PetscMax(most, PetscAbsReal(u[d]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d++) {
    if (PetscAbsReal(u[d]) < (1. - EQUAL) * most) continue;
    first = PetscMin(first, 2 * (2 * m->mesh.vertex_file[d / 2] + d % 2) + (u[d] < 0.));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPIU_INT, MPI_MIN, m->comm));
  *scale = first % 2 ? -most : most;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the modes into the result, with masses, factors and errors. */
static PetscErrorCode take_modes(const Model *m, const Stiffness *s, const Mass *mass, const Modes *modes,
                                 Vibration *v)
{
  const PetscInt n = modes->n;
  PetscReal *u;
  PetscFunctionBeginUser;
  v->n = n, v->missed = modes->missed, v->reduced = (PetscBool)(m->condensed.mode_start != NULL);
  PetscCall(PetscMalloc5(n, &v->omega2, n, &v->mass, 2 * n, &v->factor, 2 * n * m->mesh.n_owned, &v->shape, n,
                         &v->error));
  PetscCall(PetscMalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &u));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *phi = modes->shapes + i * modes->rows;
    PetscReal scale = 1., *factor = v->factor + 2 * i;
    PetscCall(find_shape(m, s, phi, u));
    PetscCall(scale_of(m, u, &scale));
    v->omega2[i] = PetscAbsReal(modes->omega2[i]) < modes->rounding ? 0. : modes->omega2[i];
    v->mass[i] = 1. / (scale * scale); // phi.M phi = 1
    v->error[i] = 0.;
    if (v->reduced) PetscCall(InsideError(m, u, v->omega2[i], v->error + i));
    for (int x = 0; x < 2; x++) {
      factor[x] = 0.;
      for (PetscInt row = 0; row < mass->rows; row++)
        factor[x] += scale * phi[row] * mass->pull[x * mass->rows + row];
    }
    for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d++) v->shape[2 * (d / 2 * n + i) + d % 2] = u[d] / scale;
  }
  PetscCall(PetscFree(u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, v->factor, (PetscMPIInt)(2 * n), MPIU_REAL, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the whole */

/* Collective. Refuses a stage without memory for its factors. Two factors exist at the same time: one of
   the search, one of a count. */
static PetscErrorCode check_memory(const Problem *p, PetscBool fits, const double memory[2])
{
  char message[MESSAGE_LENGTH];
  PetscFunctionBeginUser;
  if (fits) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                          "stage %s: no memory for the factors that modes need: about %.3g GB, %.3g GB are "
                          "available: take more machines",
                          p->stage->name, 1e-9 * memory[0], 1e-9 * memory[1]));
  PetscCall(Refuse(p->m->comm, ERROR_MEMORY, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode VibrationFind(const Problem *p, Vibration *v)
{
  const PetscReal omega_max = p->stage->up_to < PETSC_INFINITY ? 2. * PETSC_PI * p->stage->up_to : 0.;
  const PetscInt most = p->stage->count ? p->stage->count : omega_max > 0. ? 0 : 6;
  Contacts now = {.n = 0};
  Stiffness s;
  Mass mass;
  Mat K;
  Modes modes;
  double memory[2];
  PetscInt64 n_dof = p->m->n_dof + p->m->condensed.n_modes;
  PetscBool fits;
  PetscFunctionBeginUser;
  PetscCall(check_masses(p));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n_dof, 1, MPIU_INT64, MPI_SUM, p->m->comm));
  const double factors = 2. * MemoryOfFactor((double)n_dof, 0., p->m->size);
  PetscCall(MemoryFits(p->m->comm, factors / (double)p->m->size, memory, &fits));
  PetscCall(check_memory(p, fits, memory));
  PetscCall(copy_contacts(p, &now, v->contacts));
  PetscCall(StiffnessCreate(p->m, p->state, &now, &s));
  s.small = PETSC_TRUE;
  PetscCall(StiffnessBodies(p->m, p->state, PETSC_TRUE, &s));
  PetscCall(StiffnessTangent(p->m, p->state, p->stage->joints, &now, PETSC_FALSE, &s));
  PetscCall(InsideStiffness(p->m, s.tangent, &K));
  PetscCall(mass_create(p, K, &mass, v->moving));
  PetscCall(LowestModes(K, mass.M, omega_max, most, &modes));
  PetscCall(check_memory(p, (PetscBool)!modes.wants, memory));
  PetscCall(take_modes(p->m, &s, &mass, &modes, v));
  PetscCall(ModesDestroy(&modes));
  PetscCall(MatDestroy(&K));
  PetscCall(MatDestroy(&mass.M));
  PetscCall(PetscFree(mass.pull));
  PetscCall(StiffnessDestroy(&s));
  PetscCall(ContactsDestroy(&now));
  PetscFunctionReturn(PETSC_SUCCESS);
}
