/* rigid.c: computes the motion of rigid bodies (single blocks or rigid macroblocks), with three dofs at
   the centre of mass. Vertex forces are summed at the centre. Vertex positions follow from centre and
   angle, never from summed velocities, because then the shape would drift. In small strain both are
   linear: u + theta x r, with lever arms of the reference configuration. */
#include "blocks/blocks.h"

/* Sums over the blocks of a body. The functions that add to them take moments about `about` (rigid.n,2);
   NULL: about the origin. */
typedef struct {
  PetscReal area, area_x, area_y, mass, mass_x, mass_y, inertia;
} BodySums;

static void add_blocks(const Model *m, const Elements *e, const PetscReal *about, BodySums *sum)
{
  for (PetscInt i = 0; i < e->n; i++) {
    PetscInt vertex[4] = {VertexOf(e, i, 0)};
    PetscReal area, centroid[2], polar;
    for (int k = 1; k < e->n_nodes; k++) vertex[k] = VertexOf(e, i, k);
    if (vertex[0] >= m->mesh.n_owned) continue; // the body of a ghost belongs to another rank
    const PetscInt body = RigidOfVertex(m, vertex[0]);
    BlockGeometry(m->mesh.X, vertex, e->n_nodes, &area, centroid, &polar);
    const PetscReal mass = m->materials.density[e->group[i]] * m->materials.thickness * area;
    const PetscReal dx = centroid[0] - (about ? about[2 * body] : 0.),
                    dy = centroid[1] - (about ? about[2 * body + 1] : 0.);
    BodySums *s = sum + body;
    s->area += area, s->area_x += area * dx, s->area_y += area * dy;
    s->mass += mass, s->mass_x += mass * dx, s->mass_y += mass * dy;
    s->inertia += m->materials.density[e->group[i]] * m->materials.thickness * polar +
                  mass * (dx * dx + dy * dy);
  }
}

/* Adds the lumped masses (27) of deformable blocks at vertices of a body that they share: these masses
   move with the body. */
static void add_hanging(const Model *m, const PetscReal *vertex_mass, const PetscReal *about, BodySums *sum)
{
  for (PetscInt b = 0; b < m->rigid.n; b++)
    for (PetscInt v = m->rigid.start[b]; v < m->rigid.start[b + 1]; v++) {
      const PetscReal dx = m->mesh.X[2 * v] - (about ? about[2 * b] : 0.),
                      dy = m->mesh.X[2 * v + 1] - (about ? about[2 * b + 1] : 0.);
      sum[b].mass += vertex_mass[v], sum[b].mass_x += vertex_mass[v] * dx,
          sum[b].mass_y += vertex_mass[v] * dy;
      sum[b].inertia += vertex_mass[v] * (dx * dx + dy * dy);
    }
}

/* Computes the centre of mass (of area for a weightless body), then mass and inertia (30) about it. All
   are exact for polygons. */
static PetscErrorCode body_masses(Model *m)
{
  RigidBodies *bodies = &m->rigid;
  BodySums *sum;
  PetscReal *vertex_mass;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(bodies->n, &sum));
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &vertex_mass));
  PetscCall(ElementMasses(m, vertex_mass));
  add_blocks(m, &m->mesh.rigid_q4, NULL, sum);
  add_blocks(m, &m->mesh.rigid_t3, NULL, sum);
  add_hanging(m, vertex_mass, NULL, sum);
  for (PetscInt b = 0; b < bodies->n; b++) {
    const PetscBool heavy = (PetscBool)(sum[b].mass > 0.);
    bodies->X[2 * b] = heavy ? sum[b].mass_x / sum[b].mass : sum[b].area_x / sum[b].area;
    bodies->X[2 * b + 1] = heavy ? sum[b].mass_y / sum[b].mass : sum[b].area_y / sum[b].area;
  }
  PetscCall(PetscArrayzero(sum, bodies->n));
  add_blocks(m, &m->mesh.rigid_q4, bodies->X, sum);
  add_blocks(m, &m->mesh.rigid_t3, bodies->X, sum);
  add_hanging(m, vertex_mass, bodies->X, sum);
  for (PetscInt b = 0; b < bodies->n; b++)
    bodies->mass[2 * b] = sum[b].mass, bodies->mass[2 * b + 1] = sum[b].inertia;
  PetscCall(PetscFree(vertex_mass));
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RigidBodiesCreate(Model *m)
{
  const LocalMesh *mesh = &m->mesh;
  RigidBodies *bodies = &m->rigid;
  PetscFunctionBeginUser;
  bodies->n = 0;
  for (PetscInt v = mesh->n_deformable; v < mesh->n_moving; v++)
    if (v == mesh->n_deformable || mesh->vertex_rigid[v] != mesh->vertex_rigid[v - 1]) bodies->n++;
  PetscCall(PetscMalloc5(bodies->n, &bodies->gid, bodies->n + 1, &bodies->start, 2 * bodies->n, &bodies->X,
                         2 * bodies->n, &bodies->mass, bodies->n, &bodies->body));
  PetscInt body = 0;
  for (PetscInt v = mesh->n_deformable; v < mesh->n_moving; v++) {
    if (v > mesh->n_deformable && mesh->vertex_rigid[v] == mesh->vertex_rigid[v - 1]) continue;
    bodies->gid[body] = mesh->vertex_rigid[v];
    bodies->body[body] = mesh->vertex_body[v];
    bodies->start[body++] = v;
  }
  bodies->start[bodies->n] = mesh->n_moving;
  PetscCall(body_masses(m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void RigidForces(const Model *m, const PetscReal *u, PetscReal *f)
{
  const PetscReal *u_vertex = u + 3 * m->rigid.n, *f_vertex = f + 3 * m->rigid.n;
  const PetscReal moving = m->materials.strain == STRAIN_LARGE ? 1. : 0.;
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    const PetscReal *C = m->rigid.X + 2 * b;
    PetscReal fx = 0., fy = 0., moment = 0.;
    for (PetscInt v = m->rigid.start[b]; v < m->rigid.start[b + 1]; v++) {
      // lever arm from the centre in the present position (small strain: in the reference position)
      const PetscReal rx = (m->mesh.X[2 * v] - C[0]) + moving * (u_vertex[2 * v] - u[3 * b]);
      const PetscReal ry = (m->mesh.X[2 * v + 1] - C[1]) + moving * (u_vertex[2 * v + 1] - u[3 * b + 1]);
      fx += f_vertex[2 * v];
      fy += f_vertex[2 * v + 1];
      moment += rx * f_vertex[2 * v + 1] - ry * f_vertex[2 * v];
    }
    f[3 * b] = fx, f[3 * b + 1] = fy, f[3 * b + 2] = moment;
  }
}

void RigidMotion(const Model *m, PetscReal *u)
{
  PetscReal *u_vertex = u + 3 * m->rigid.n;
  const PetscBool large = (PetscBool)(m->materials.strain == STRAIN_LARGE);
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    const PetscReal *C = m->rigid.X + 2 * b, theta = u[3 * b + 2],
                    half = large ? PetscSinReal(0.5 * theta) : 0.;
    const PetscReal s = large ? PetscSinReal(theta) : theta,
                    c1 = -2. * half * half; // cos(theta) - 1 without loss of digits
    for (PetscInt v = m->rigid.start[b]; v < m->rigid.start[b + 1]; v++) {
      const PetscReal rx = m->mesh.X[2 * v] - C[0], ry = m->mesh.X[2 * v + 1] - C[1];
      u_vertex[2 * v] = u[3 * b] + (c1 * rx - s * ry);         // (21) integrated exactly
      u_vertex[2 * v + 1] = u[3 * b + 1] + (s * rx + c1 * ry); // (22)
    }
  }
}

PetscErrorCode DisplacementsComplete(const Model *m, PetscReal *u)
{
  PetscFunctionBeginUser;
  RigidMotion(m, u);
  PetscCall(GhostBegin(m, u + 3 * m->rigid.n));
  PetscCall(GhostEnd(m, u + 3 * m->rigid.n));
  PetscFunctionReturn(PETSC_SUCCESS);
}
