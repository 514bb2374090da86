/* locate.c: finds the block that contains a point, with the shape functions there, and the part of a line in
   a block. */
#include "mesh/mesh.h"

static const PetscReal OUTSIDE = 1e-9; /* of the diameter of the mesh: a point on a face is in the block */
enum { SWEEPS = 12 };                  /* of Newton's method; a convex block takes 5 */

PetscReal LocateTolerance(PetscReal diameter)
{
  return OUTSIDE * diameter;
}

static PetscBool is_inside(PetscInt n, const PetscReal *x, const PetscReal point[2], PetscReal tolerance)
{
  for (PetscInt k = 0; k < n; k++) { // to the left of each face
    const PetscReal *a = x + 2 * k, *b = x + 2 * ((k + 1) % n);
    const PetscReal dx = b[0] - a[0], dy = b[1] - a[1];
    if (dx * (point[1] - a[1]) - dy * (point[0] - a[0]) < -tolerance * PetscHypotReal(dx, dy))
      return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

static PetscReal twice_area(const PetscReal a[2], const PetscReal b[2], const PetscReal c[2])
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static void weights_in_triangle(const PetscReal *x, const PetscReal point[2], PetscReal weight[4])
{
  const PetscReal all = twice_area(x, x + 2, x + 4);
  weight[1] = twice_area(x, point, x + 4) / all;
  weight[2] = twice_area(x, x + 2, point) / all;
  weight[0] = 1. - weight[1] - weight[2];
  weight[3] = 0.;
}

/* Inverts the bilinear map of the unit square by Newton's method, from the middle. */
static void weights_in_quadrilateral(const PetscReal *x, const PetscReal point[2], PetscReal weight[4])
{
  PetscReal s = 0.5, t = 0.5;
  for (int sweep = 0; sweep <= SWEEPS; sweep++) {
    PetscReal r[2], along_s[2], along_t[2];
    weight[0] = (1. - s) * (1. - t), weight[1] = s * (1. - t), weight[2] = s * t, weight[3] = (1. - s) * t;
    for (int i = 0; i < 2; i++) {
      r[i] = point[i] - weight[0] * x[i] - weight[1] * x[2 + i] - weight[2] * x[4 + i] - weight[3] * x[6 + i];
      along_s[i] = (1. - t) * (x[2 + i] - x[i]) + t * (x[4 + i] - x[6 + i]);
      along_t[i] = (1. - s) * (x[6 + i] - x[i]) + s * (x[4 + i] - x[2 + i]);
    }
    const PetscReal det = along_s[0] * along_t[1] - along_s[1] * along_t[0];
    if (det == 0.) return; // at the corner of a block that is a triangle in all but name
    s += (r[0] * along_t[1] - r[1] * along_t[0]) / det;
    t += (along_s[0] * r[1] - along_s[1] * r[0]) / det;
    s = PetscClipInterval(s, 0., 1.), t = PetscClipInterval(t, 0., 1.);
  }
}

PetscBool LocateInBlock(PetscInt n, const PetscReal *x, const PetscReal point[2], PetscReal tolerance,
                        PetscReal weight[4])
{
  if (!is_inside(n, x, point, tolerance)) return PETSC_FALSE;
  if (n == 3)
    weights_in_triangle(x, point, weight);
  else
    weights_in_quadrilateral(x, point, weight);
  return PETSC_TRUE;
}

/* Rank 0. Returns the first block that contains the point, -1: none. */
static PetscInt block_at(const BlockMesh *mesh, const PetscReal point[2])
{
  PetscReal longest, diameter, x[8], weight[4];
  MeshMeasures(mesh, &longest, &diameter);
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt *ring = mesh->blocks + 4 * b, n = BlockCorners(ring);
    for (PetscInt k = 0; k < 2 * n; k++) x[k] = mesh->X[2 * ring[k / 2] + k % 2];
    if (LocateInBlock(n, x, point, LocateTolerance(diameter), weight)) return b;
  }
  return -1;
}

PetscBool LocateLine(PetscInt n, const PetscReal *x, const PetscReal a[2], const PetscReal b[2],
                     PetscReal tolerance, PetscReal t[2], PetscInt *leaves)
{
  const PetscReal length = PetscHypotReal(b[0] - a[0], b[1] - a[1]);
  t[0] = 0., t[1] = 1., *leaves = -1;
  for (PetscInt k = 0; k < n; k++) { // the part to the left of each face
    const PetscReal *p = x + 2 * k, *q = x + 2 * ((k + 1) % n);
    const PetscReal dx = q[0] - p[0], dy = q[1] - p[1], face = PetscHypotReal(dx, dy),
                    from = (dx * (a[1] - p[1]) - dy * (a[0] - p[0])) / face,
                    to = (dx * (b[1] - p[1]) - dy * (b[0] - p[0])) / face;
    if (PetscAbsReal(to - from) <= tolerance) { // along the face
      if (from < -tolerance) return PETSC_FALSE;
    } else if (to > from) {
      t[0] = PetscMax(t[0], -from / (to - from));
    } else if (from / (from - to) < t[1]) {
      t[1] = from / (from - to), *leaves = k;
    }
  }
  return (PetscBool)((t[1] - t[0]) * length > tolerance);
}

PetscErrorCode LocateAnchor(const BlockMesh *mesh, const Anchor *anchor,
                            PetscErrorCode (*take)(const BlockMesh *mesh, PetscInt block, void *context),
                            void *context)
{
  const PetscReal *ends[2] = {anchor->head, anchor->root};
  PetscReal longest, diameter, x[8], t[2];
  PetscInt leaves;
  PetscFunctionBeginUser;
  for (int end = 0; end < 2; end++) {
    const PetscInt b = block_at(mesh, ends[end]);
    if (b >= 0) PetscCall(take(mesh, b, context));
  }
  if (!(anchor->bond_stiffness > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  MeshMeasures(mesh, &longest, &diameter);
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt *ring = mesh->blocks + 4 * b, n = BlockCorners(ring);
    for (PetscInt k = 0; k < 2 * n; k++) x[k] = mesh->X[2 * ring[k / 2] + k % 2];
    if (LocateLine(n, x, ends[0], ends[1], 0.1 * LocateTolerance(diameter), t, &leaves))
      PetscCall(take(mesh, b, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
