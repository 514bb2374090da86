/* check.c: checks whether the content of a block mesh makes sense. The checks are all refusals of
   docs/mesh_format.md, in an order in which each check may rely on those before it. Messages use the numbers
   of the file, before and after MeshReorder. */
#include "mesh/mesh.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const PetscReal LARGEST_COORDINATE = 1e15; /* [m] products of two lengths stay far from overflow */
static const PetscReal SLIVER = 1e6;              /* aspect ratio above which a block is refused */
static const PetscReal SLENDER = 1e3;             /* aspect ratio above which a warning is given */
static const PetscReal ROUNDING = 1e-12; /* an area below this share of the longest edge squared is zero */

typedef struct {
  const BlockMesh *mesh;
  char *message; /* "" as long as no fault is found */
} Check;

static void fault(Check *c, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void fault(Check *c, const char *format, ...)
{
  va_list arguments;
  if (c->message[0]) return;
  va_start(arguments, format);
  vsnprintf(c->message, MESSAGE_LENGTH, format, arguments);
  va_end(arguments);
}

static inline PetscBool is_sound(const Check *c)
{
  return c->message[0] ? PETSC_FALSE : PETSC_TRUE;
}

static inline PetscInt corners_of(const BlockMesh *mesh, PetscInt b)
{
  return mesh->blocks[4 * b + 3] < 0 ? 3 : 4;
}

static inline const PetscReal *corner(const BlockMesh *mesh, PetscInt b, PetscInt k)
{
  return mesh->X + 2 * mesh->blocks[4 * b + k % corners_of(mesh, b)];
}

static inline PetscReal cross(const PetscReal a[2], const PetscReal b[2])
{
  return a[0] * b[1] - a[1] * b[0];
}

/* ---- names */

static int compare_names(const void *a, const void *b)
{
  return strncmp(a, b, NAME_LENGTH);
}

static PetscErrorCode check_groups(Check *c)
{
  const BlockMesh *mesh = c->mesh;
  char(*names)[NAME_LENGTH];

  PetscFunctionBegin;
  if (mesh->n_groups == 0)
    PetscFunctionReturn(PETSC_SUCCESS); /* the group row of every block is out of range then */
  PetscCall(PetscMalloc1(mesh->n_groups, &names));
  PetscCall(PetscArraycpy(names, mesh->group_names, mesh->n_groups));
  qsort(names, (size_t)mesh->n_groups, sizeof *names, compare_names);
  for (PetscInt g = 1; g < mesh->n_groups; g++)
    if (!compare_names(names[g - 1], names[g])) fault(c, "group '%s': two groups have this name", names[g]);
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- numbers in range */

static PetscErrorCode check_vertices(Check *c)
{
  PetscFunctionBegin;
  for (PetscInt v = 0; v < c->mesh->n_vertices && is_sound(c); v++) {
    const PetscReal x = c->mesh->X[2 * v], y = c->mesh->X[2 * v + 1];
    /* the condition is written so that NaN fails it too */
    if (!(PetscAbsReal(x) <= LARGEST_COORDINATE && PetscAbsReal(y) <= LARGEST_COORDINATE))
      fault(c, "vertex %" PetscInt_FMT ": coordinates (%g, %g) are not finite, or beyond 1e15 m",
            c->mesh->vertex_file[v], x, y);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void check_block_numbers(Check *c, PetscInt b)
{
  const BlockMesh *mesh = c->mesh;
  const PetscInt *v = mesh->blocks + 4 * b, id = mesh->block_file[b];

  for (int k = 0; k < 4; k++)
    if ((v[k] < 0 && !(k == 3 && v[k] == -1)) || v[k] >= mesh->n_vertices)
      fault(c,
            "block %" PetscInt_FMT ": its vertex %d is %" PetscInt_FMT ", expected 0..%" PetscInt_FMT
            " (or -1 in the last column)",
            id, k, v[k], mesh->n_vertices - 1);
  for (PetscInt k = 0; k < corners_of(mesh, b) && is_sound(c); k++)
    for (PetscInt l = 0; l < k; l++)
      if (v[k] == v[l])
        fault(c, "block %" PetscInt_FMT ": vertex %" PetscInt_FMT " is repeated", id,
              mesh->vertex_file[v[k]]);
  if (mesh->block_group[b] < 0 || mesh->block_group[b] >= mesh->n_groups)
    fault(c,
          "block %" PetscInt_FMT ": group row %" PetscInt_FMT " does not exist, the mesh has %" PetscInt_FMT
          " groups",
          id, mesh->block_group[b], mesh->n_groups);
}

static PetscErrorCode check_blocks(Check *c)
{
  const BlockMesh *mesh = c->mesh;
  PetscBool *used;

  PetscFunctionBegin;
  if (mesh->n_blocks == 0) fault(c, "the mesh has no blocks");
  for (PetscInt b = 0; b < mesh->n_blocks && is_sound(c); b++) check_block_numbers(c, b);
  if (!is_sound(c)) PetscFunctionReturn(PETSC_SUCCESS);

  PetscCall(PetscCalloc1(mesh->n_vertices, &used));
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (PetscInt k = 0; k < corners_of(mesh, b); k++) used[mesh->blocks[4 * b + k]] = PETSC_TRUE;
  for (PetscInt v = 0; v < mesh->n_vertices && is_sound(c); v++)
    if (!used[v])
      fault(c, "vertex %" PetscInt_FMT " at (%g, %g): no block uses it", mesh->vertex_file[v], mesh->X[2 * v],
            mesh->X[2 * v + 1]);
  PetscCall(PetscFree(used));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- shapes */

/* Returns the aspect ratio of a block: its longest edge over its width, or over its shortest edge where that
   ratio is larger. The width is the width of a rectangle with the block's area (the height of a triangle). So
   both a thin block and a tiny face count. */
static PetscReal aspect_ratio(const BlockMesh *mesh, PetscInt b)
{
  const PetscInt corners = corners_of(mesh, b);
  const PetscReal *o = corner(mesh, b, 0);
  PetscReal longest = 0, shortest = PETSC_INFINITY, area = 0;

  for (PetscInt k = 0; k < corners; k++) {
    const PetscReal *p = corner(mesh, b, k), *q = corner(mesh, b, k + 1);
    const PetscReal length = hypot(q[0] - p[0], q[1] - p[1]);
    longest = PetscMax(longest, length);
    shortest = PetscMin(shortest, length);
    area += cross((PetscReal[2]){p[0] - o[0], p[1] - o[1]}, (PetscReal[2]){q[0] - o[0], q[1] - o[1]}) /
            (corners == 3 ? 1 : 2);
  }
  return PetscMax(longest * longest / area, longest / shortest);
}

/* Refuses slivers. A contact with a sliver, or with a face that is tiny beside the others, has no stiffness
   or mass that a time step could follow, so the motion of such a block is rounding. */
static void check_sliver(Check *c, PetscInt b)
{
  const PetscReal ratio = aspect_ratio(c->mesh, b), *at = corner(c->mesh, b, 0);
  if (ratio > SLIVER)
    fault(c, "block %" PetscInt_FMT " at (%g, %g): a sliver of aspect ratio %.3g, expected at most %g",
          c->mesh->block_file[b], at[0], at[1], ratio, SLIVER);
}

void MeshSlender(const BlockMesh *mesh, PetscInt *n, PetscInt *worst, PetscReal *ratio)
{
  *n = 0, *worst = -1, *ratio = SLENDER;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscReal r = aspect_ratio(mesh, b);
    if (r > SLENDER) (*n)++;
    if (r > *ratio) *worst = mesh->block_file[b], *ratio = r;
  }
}

static void check_shape(Check *c, PetscInt b)
{
  const BlockMesh *mesh = c->mesh;
  const PetscInt corners = corners_of(mesh, b), id = mesh->block_file[b];
  PetscReal edge[4][2], longest = 0, area = 0;

  for (PetscInt k = 0; k < corners; k++) {
    for (int a = 0; a < 2; a++) edge[k][a] = corner(mesh, b, k + 1)[a] - corner(mesh, b, k)[a];
    longest = PetscMax(longest, PetscSqr(edge[k][0]) + PetscSqr(edge[k][1]));
  }
  /* a fan of triangles from corner 0 needs differences of coordinates only, so blocks far away lose no
     digits */
  for (PetscInt k = 1; k + 1 < corners; k++) {
    const PetscReal *o = corner(mesh, b, 0), *p = corner(mesh, b, k), *q = corner(mesh, b, k + 1);
    area += 0.5 * cross((PetscReal[2]){p[0] - o[0], p[1] - o[1]}, (PetscReal[2]){q[0] - o[0], q[1] - o[1]});
  }
  const PetscReal *at = corner(mesh, b, 0), smallest = ROUNDING * longest;
  if (!(PetscAbsReal(area) > smallest))
    fault(c, "block %" PetscInt_FMT " at (%g, %g): its area is zero", id, at[0], at[1]);
  if (area < 0)
    fault(c, "block %" PetscInt_FMT " at (%g, %g): inverted, its vertices run clockwise (area %g m2)", id,
          at[0], at[1], area);
  for (PetscInt k = 0; k < corners; k++) {
    const PetscInt v = mesh->blocks[4 * b + k], w = mesh->blocks[4 * b + (k + 1) % corners];
    if (PetscSqr(edge[k][0]) + PetscSqr(edge[k][1]) <= PetscSqr(ROUNDING) * longest)
      fault(c,
            "block %" PetscInt_FMT ": its vertices %" PetscInt_FMT " and %" PetscInt_FMT
            " are at the same place",
            id, mesh->vertex_file[v], mesh->vertex_file[w]);
    /* a straight corner still counts as convex */
    if (cross(edge[(k + corners - 1) % corners], edge[k]) < -smallest)
      fault(c, "block %" PetscInt_FMT ": not convex at its vertex %" PetscInt_FMT " (%g, %g)", id,
            mesh->vertex_file[v], corner(mesh, b, k)[0], corner(mesh, b, k)[1]);
  }
}

static PetscErrorCode check_shapes(Check *c)
{
  PetscFunctionBegin;
  for (PetscInt b = 0; b < c->mesh->n_blocks && is_sound(c); b++) {
    check_shape(c, b);
    if (is_sound(c)) check_sliver(c, b);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- edges and face sets */

/* Checks that each edge belongs to one block, or to two blocks that run it in opposite directions. Marks the
   faces that only one block has. */
static PetscErrorCode check_edges(Check *c, PetscBool *outer)
{
  const BlockMesh *mesh = c->mesh;
  PetscInt n_edges, *vertices, *block_edges, *uses, *first;

  PetscFunctionBegin;
  if (!is_sound(c)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeshEdges(mesh, &n_edges, &vertices, &block_edges));
  PetscCall(PetscCalloc2(n_edges, &uses, n_edges, &first));
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (PetscInt k = 0; k < corners_of(mesh, b); k++) {
      const PetscInt e = EDGE_INDEX(block_edges[4 * b + k]);
      if (uses[e]++ == 0) first[e] = b;
    }
  for (PetscInt e = 0; e < n_edges && is_sound(c); e++)
    if (uses[e] > 2)
      fault(c,
            "edge between vertices %" PetscInt_FMT " and %" PetscInt_FMT " is shared by %" PetscInt_FMT
            " blocks",
            mesh->vertex_file[vertices[2 * e]], mesh->vertex_file[vertices[2 * e + 1]], uses[e]);
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (PetscInt k = 0; k < corners_of(mesh, b); k++) {
      const PetscInt signed_e = block_edges[4 * b + k], e = EDGE_INDEX(signed_e);
      outer[4 * b + k] = uses[e] == 1 ? PETSC_TRUE : PETSC_FALSE;
      if (b != first[e] && signed_e >= 0)
        fault(c,
              "blocks %" PetscInt_FMT " and %" PetscInt_FMT
              " lie on the same side of their edge between vertices "
              "%" PetscInt_FMT " and %" PetscInt_FMT,
              mesh->block_file[first[e]], mesh->block_file[b], mesh->vertex_file[vertices[2 * e]],
              mesh->vertex_file[vertices[2 * e + 1]]);
    }
  PetscCall(PetscFree2(uses, first));
  PetscCall(PetscFree(vertices));
  PetscCall(PetscFree(block_edges));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the faces of a set. marked: (n_blocks,4) number of the last set that names the face. */
static void check_face_set(Check *c, PetscInt s, const PetscBool *outer, PetscInt *marked)
{
  const BlockMesh *mesh = c->mesh;
  const FaceSet *set = &mesh->face_sets[s];

  for (PetscInt i = 0; i < set->n && is_sound(c); i++) {
    const PetscInt b = set->faces[2 * i], k = set->faces[2 * i + 1];
    if (b < 0 || b >= mesh->n_blocks) {
      fault(c,
            "face set '%s', row %" PetscInt_FMT ": block %" PetscInt_FMT
            " does not exist, expected 0..%" PetscInt_FMT,
            set->name, i, b, mesh->n_blocks - 1);
    } else if (k < 0 || k >= corners_of(mesh, b)) {
      fault(c,
            "face set '%s', row %" PetscInt_FMT ": block %" PetscInt_FMT " has no face %" PetscInt_FMT
            ", expected 0..%" PetscInt_FMT,
            set->name, i, mesh->block_file[b], k, corners_of(mesh, b) - 1);
    } else if (marked[4 * b + k] == s) {
      fault(c, "face set '%s': face %" PetscInt_FMT " of block %" PetscInt_FMT " is listed twice", set->name,
            k, mesh->block_file[b]);
    } else if (!outer[4 * b + k]) {
      fault(c,
            "face set '%s', row %" PetscInt_FMT ": face %" PetscInt_FMT " of block %" PetscInt_FMT
            " is inside its macroblock, expected a face on the boundary",
            set->name, i, k, mesh->block_file[b]);
    } else {
      marked[4 * b + k] = s;
    }
  }
}

static PetscErrorCode check_sets(Check *c, const PetscBool *outer)
{
  const BlockMesh *mesh = c->mesh;
  PetscInt *marked;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(4 * (size_t)mesh->n_blocks, &marked));
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++) marked[i] = -1;
  for (PetscInt s = 0; s < mesh->n_face_sets && is_sound(c); s++) check_face_set(c, s, outer, marked);
  PetscCall(PetscFree(marked));
  for (PetscInt p = 0; p < mesh->n_points && is_sound(c); p++)
    if (mesh->point_vertex[p] < 0 || mesh->point_vertex[p] >= mesh->n_vertices)
      fault(c, "point '%s': vertex %" PetscInt_FMT " does not exist, expected 0..%" PetscInt_FMT,
            mesh->point_names[p], mesh->point_vertex[p], mesh->n_vertices - 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- overlap of macroblocks */

/* Returns the distance that block a must move along one of its own face normals to be clear of block b; < 0:
   a is clear already. */
static PetscReal clearing_distance(const BlockMesh *mesh, PetscInt a, PetscInt b)
{
  PetscReal least = PETSC_INFINITY;
  for (PetscInt k = 0; k < corners_of(mesh, a); k++) {
    const PetscReal *p = corner(mesh, a, k), *q = corner(mesh, a, k + 1);
    const PetscReal edge[2] = {q[0] - p[0], q[1] - p[1]}, length = hypot(edge[0], edge[1]);
    PetscReal depth = -PETSC_INFINITY;
    /* block a is convex and counter-clockwise, so it lies to the left of its face; the deepest corner of b on
       that side decides */
    for (PetscInt l = 0; l < corners_of(mesh, b); l++) {
      const PetscReal *x = corner(mesh, b, l);
      depth = PetscMax(depth, cross(edge, (PetscReal[2]){x[0] - p[0], x[1] - p[1]}) / length);
    }
    least = PetscMin(least, depth);
  }
  return least;
}

/* Computes the envelopes of all blocks [m] (n_blocks,4), each shrunk by half the tolerance. Two bodies that
   overlap deeper than the tolerance also overlap by more than it along x and along y, so their shrunk
   envelopes meet; the shrunk envelopes of neighbours that only touch do not. */
static PetscErrorCode shrunk_boxes(const BlockMesh *mesh, PetscReal tolerance, PetscReal **boxes)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(4 * (size_t)mesh->n_blocks, boxes));
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (int a = 0; a < 2; a++) {
      PetscReal low = PETSC_INFINITY, high = -PETSC_INFINITY;
      for (PetscInt k = 0; k < corners_of(mesh, b); k++) {
        low = PetscMin(low, corner(mesh, b, k)[a]);
        high = PetscMax(high, corner(mesh, b, k)[a]);
      }
      const PetscReal shrink = PetscMin(0.5 * tolerance, 0.49 * (high - low));
      (*boxes)[4 * b + a] = low + shrink;
      (*boxes)[4 * b + 2 + a] = high - shrink;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  Check *check;
  PetscReal tolerance;
} OverlapCheck;

static PetscErrorCode check_pair(PetscInt i, PetscInt j, PetscBool *stop, void *context)
{
  const OverlapCheck *o = context;
  const BlockMesh *mesh = o->check->mesh;

  PetscFunctionBegin;
  if (mesh->body[i] == mesh->body[j]) PetscFunctionReturn(PETSC_SUCCESS);
  /* convex polygons are apart when one of their face normals separates them; otherwise the shortest way out
     is along such a normal */
  PetscReal depth = clearing_distance(mesh, i, j);
  if (depth > o->tolerance) depth = PetscMin(depth, clearing_distance(mesh, j, i));
  if (depth > o->tolerance) {
    const PetscInt a = mesh->block_file[i], b = mesh->block_file[j];
    fault(o->check,
          "blocks %" PetscInt_FMT " and %" PetscInt_FMT
          " of different macroblocks overlap by %.3g m (tolerance %g m)",
          PetscMin(a, b), PetscMax(a, b), depth, o->tolerance);
    *stop = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode check_overlap(Check *c, PetscReal tolerance)
{
  OverlapCheck context = {.check = c, .tolerance = tolerance};
  PetscReal *boxes;

  PetscFunctionBegin;
  if (!is_sound(c) || c->mesh->n_bodies < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(shrunk_boxes(c->mesh, tolerance, &boxes));
  PetscCall(GridVisit(c->mesh->n_blocks, boxes, check_pair, &context));
  PetscCall(PetscFree(boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshOverlap(const BlockMesh *mesh, PetscReal tolerance, char message[MESSAGE_LENGTH])
{
  Check check = {.mesh = mesh, .message = message};

  PetscFunctionBegin;
  message[0] = 0;
  PetscCall(check_overlap(&check, tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshCheck(const BlockMesh *mesh, PetscReal overlap_tolerance, char message[MESSAGE_LENGTH])
{
  Check check = {.mesh = mesh, .message = message};
  PetscBool *outer;

  PetscFunctionBegin;
  message[0] = 0;
  PetscCall(check_groups(&check));
  PetscCall(check_vertices(&check));
  PetscCall(check_blocks(&check));
  if (!is_sound(&check)) PetscFunctionReturn(PETSC_SUCCESS); /* the next checks follow indices */
  PetscCall(check_shapes(&check));
  PetscCall(PetscCalloc1(4 * (size_t)mesh->n_blocks, &outer));
  PetscCall(check_edges(&check, outer));
  PetscCall(check_sets(&check, outer));
  PetscCall(PetscFree(outer));
  PetscCall(check_overlap(&check, overlap_tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}
