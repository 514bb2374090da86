/* nested_factor.c: factorises the elastic stiffness, supernode by supernode (multifrontal: Duff and Reid, ACM
   Trans. Math. Softw. 9, 1983).

   The front of a supernode with columns c and rows r below them holds the entries of the matrix in these
   columns and the updates of its children. With F_cc = L L', L_r = F_rc L'^-1, what is left for its parent is
   F_rr - L_r L_r'. The solver needs B = [L^-1; -L_r L^-1]: forward, x_c becomes L^-1 x_c, and x_r gets
   -L_r L^-1 x_c; backward, x_c becomes B' [x_c; x_r]. */
#include "solve/nested.h"
#include <petscblaslapack.h>

typedef struct {
  const NestedOrder *o;
  PetscInt *start, *row; /* entries of the matrix in each column, in the order of elimination */
  PetscReal *value;
  PetscInt *child, *next; /* (n_supers,) first child; next child of the same parent */
  PetscReal **update;     /* (n_supers,) what is left for the parent */
  PetscInt *local;        /* (n,) row of the front */
  PetscReal *F, *B;       /* the front, and the result, of a supernode */
} Fronts;

/* Sorts the entries of the matrix into the columns of the factor. */
static PetscErrorCode sort_entries(const ElasticMatrix *x, Fronts *f)
{
  const PetscInt *place = f->o->place;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(x->n + 2, &f->start));
  PetscCall(PetscMalloc2(x->start[x->n], &f->row, x->start[x->n], &f->value));
  for (PetscInt i = 0; i < x->n; i++)
    for (PetscInt e = x->start[i]; e < x->start[i + 1]; e++)
      f->start[PetscMin(place[i], place[x->column[e]]) + 2]++;
  for (PetscInt i = 0; i < x->n; i++) f->start[i + 2] += f->start[i + 1];
  for (PetscInt i = 0; i < x->n; i++)
    for (PetscInt e = x->start[i]; e < x->start[i + 1]; e++) {
      const PetscInt p = place[i], q = place[x->column[e]], at = f->start[PetscMin(p, q) + 1]++;
      f->row[at] = PetscMax(p, q), f->value[at] = x->value[e];
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the entries of the matrix and the updates of the children to the front F (n, n) of supernode s, its
   lower triangle by columns. */
static PetscErrorCode assemble(Fronts *f, PetscInt s, PetscInt n, PetscReal *F)
{
  const NestedOrder *o = f->o;
  const PetscInt first = o->first[s], width = o->first[s + 1] - first;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(F, (size_t)n * n));
  for (PetscInt i = 0; i < width; i++) f->local[first + i] = i;
  for (PetscInt i = width; i < n; i++) f->local[o->row[o->row_start[s] + i - width]] = i;
  for (PetscInt c = 0; c < width; c++)
    for (PetscInt e = f->start[first + c]; e < f->start[first + c + 1]; e++)
      F[(size_t)c * n + f->local[f->row[e]]] += f->value[e];
  for (PetscInt c = f->child[s]; c >= 0; c = f->next[c]) {
    const PetscInt *row = o->row + o->row_start[c], m = o->row_start[c + 1] - o->row_start[c];
    for (PetscInt j = 0; j < m; j++) {
      PetscReal *to = F + (size_t)f->local[row[j]] * n;
      for (PetscInt i = j; i < m; i++) to[f->local[row[i]]] += f->update[c][(size_t)j * m + i];
    }
    PetscCall(PetscFree(f->update[c]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Eliminates the columns of the front, keeps the update for the parent, and computes B (n, width) by
   columns. */
static PetscErrorCode eliminate(PetscInt width, PetscInt n, PetscReal *F, PetscReal **update, PetscReal *B,
                                PetscBool *positive)
{
  const PetscReal one = 1., minus = -1.;
  PetscBLASInt w, r, lead, info;
  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(width, &w));
  PetscCall(PetscBLASIntCast(n - width, &r));
  PetscCall(PetscBLASIntCast(n, &lead));
  PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("L", &w, F, &lead, &info));
  *positive = (PetscBool)(info == 0);
  if (!*positive) PetscFunctionReturn(PETSC_SUCCESS);
  if (r) {
    PetscCallBLAS("BLAStrsm", BLAStrsm_("R", "L", "T", "N", &r, &w, &one, F, &lead, F + width, &lead));
    PetscCall(PetscMalloc1((size_t)r * r, update));
    for (PetscInt j = 0; j < r; j++)
      PetscCall(PetscArraycpy(*update + (size_t)j * r + j, F + (size_t)(width + j) * n + width + j, r - j));
    PetscCallBLAS("BLASsyrk", BLASsyrk_("L", "N", &r, &w, &minus, F + width, &lead, &one, *update, &r));
  }
  for (PetscInt c = 0; c < width; c++)
    for (PetscInt i = 0; i < n; i++)
      B[(size_t)c * n + i] = i < width ? (PetscReal)(i == c) : -F[(size_t)c * n + i];
  PetscCallBLAS("BLAStrsm",
                BLAStrsm_("R", "L", "N", "N", &lead, &w, &one, F, &lead, B, &lead)); // [1; -L_r] L^-1
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes B (n, width) as the solver reads it. */
static void pack(PetscInt width, PetscInt n, const PetscReal *B, NestedReal *to)
{
  for (PetscInt panel = 0; panel < width; panel += NESTED_PANEL)
    for (PetscInt at = panel / NESTED_LANES * NESTED_LANES; at < n; at += NESTED_LANES)
      for (PetscInt c = panel; c < PetscMin(panel + NESTED_PANEL, width); c++)
        for (PetscInt i = at; i < at + NESTED_LANES; i++)
          *to++ = i < n ? (NestedReal)B[(size_t)c * n + i] : 0.f;
}

static PetscErrorCode free_fronts(Fronts *f)
{
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < f->o->n_supers && f->update; s++) PetscCall(PetscFree(f->update[s]));
  PetscCall(PetscFree2(f->F, f->B));
  PetscCall(PetscFree(f->local));
  PetscCall(PetscFree(f->update));
  PetscCall(PetscFree2(f->child, f->next));
  PetscCall(PetscFree(f->start));
  PetscCall(PetscFree2(f->row, f->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode factorise(const ElasticMatrix *x, const NestedOrder *o, Fronts *f, NestedReal **values,
                                PetscBool *positive)
{
  PetscInt most = 0, widest = 0;
  size_t size = 0;
  PetscFunctionBeginUser;
  *positive = PETSC_TRUE;
  PetscCall(sort_entries(x, f));
  PetscCall(PetscMalloc2(o->n_supers, &f->child, o->n_supers, &f->next));
  PetscCall(PetscCalloc1(o->n_supers, &f->update));
  PetscCall(PetscMalloc1(o->n, &f->local));
  for (PetscInt s = 0; s < o->n_supers; s++) f->child[s] = -1;
  for (PetscInt s = o->n_supers; s-- > 0;) {
    const PetscInt width = o->first[s + 1] - o->first[s], n = width + o->row_start[s + 1] - o->row_start[s];
    size += NestedSize(width, n), most = PetscMax(most, n), widest = PetscMax(widest, width);
    if (o->parent[s] >= 0) f->next[s] = f->child[o->parent[s]], f->child[o->parent[s]] = s;
  }
  PetscCall(PetscMalloc2((size_t)most * most, &f->F, (size_t)most * widest, &f->B));
  PetscCall(PetscMalloc1(size, values));
  size = 0;
  for (PetscInt s = 0; s < o->n_supers && *positive; s++) {
    const PetscInt width = o->first[s + 1] - o->first[s], n = width + o->row_start[s + 1] - o->row_start[s];
    PetscCall(assemble(f, s, n, f->F));
    PetscCall(eliminate(width, n, f->F, f->update + s, f->B, positive));
    if (*positive) pack(width, n, f->B, *values + size);
    size += NestedSize(width, n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NestedFactorise(const ElasticMatrix *x, const NestedOrder *o, NestedReal **values,
                               PetscBool *positive)
{
  Fronts f = {.o = o};
  PetscFunctionBeginUser;
  const PetscErrorCode code = factorise(x, o, &f, values, positive);
  PetscCall(free_fronts(&f));
  PetscCall(code); // explicit cycles need the memory
  PetscFunctionReturn(PETSC_SUCCESS);
}
