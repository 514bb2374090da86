/* anchors_setup.c: finds the blocks at the ends of the anchors, and refuses or warns of bad anchors. */
#include "anchors/line.h"

static const PetscReal *end_of(const Anchor *anchors, PetscInt i)
{
  return i % 2 ? anchors[i / 2].root : anchors[i / 2].head;
}

/* Vertices of the blocks of one anchor. */
typedef struct {
  PetscInt n, room, *gids;
} Coupled;

static PetscErrorCode couple_block(const BlockMesh *mesh, PetscInt b, void *context)
{
  Coupled *to = context;
  PetscFunctionBeginUser;
  if (to->n + 4 > to->room) {
    to->room = 2 * to->room + 8;
    PetscCall(PetscRealloc(to->room * sizeof *to->gids, &to->gids));
  }
  for (PetscInt k = 0; k < BlockCorners(mesh->blocks + 4 * b); k++)
    to->gids[to->n++] = mesh->blocks[4 * b + k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsReads(const Scene *scene, const BlockMesh *mesh, TermCouple couple, void *context)
{
  Coupled all = {0, 0, NULL};
  PetscInt n;
  const Anchor *anchors = SceneEntries(scene, "anchors", &n);
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) { // AnchorsCreate refuses an end in no block
    all.n = 0;
    PetscCall(LocateAnchor(mesh, anchors + i, couple_block, &all));
    if (all.n) PetscCall(PetscSortRemoveDupsInt(&all.n, all.gids));
    PetscCall(couple(all.n, all.gids, context));
  }
  PetscCall(PetscFree(all.gids));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the blocks at the ends */

/* The block at an end, as all ranks know it. */
typedef struct {
  PetscInt block, body, other_body; /* lowest block that contains the end (PETSC_MAX_INT: none), lowest and
                                       highest body */
  PetscInt group;                   /* group of the block, preferably one that no stage builds later */
  PetscInt gid[4];                  /* its vertices, -1: triangle */
  PetscReal weight[4];
} End;

/* Finds the blocks of this rank that contain the point: the lowest block, and the bodies. full: also its
   vertices, from the rank that owns it. */
static void find_block(const Scene *scene, const Model *m, const PetscReal point[2], PetscBool full, End *end)
{
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++) {
      PetscReal x[8], weight[4];
      if (full && (list->gid[e] != end->block || !list->owned[e])) continue;
      for (PetscInt k = 0; k < 2 * list->n_nodes; k++) x[k] = m->mesh.X[2 * VertexOf(list, e, k / 2) + k % 2];
      if (!LocateInBlock(list->n_nodes, x, point, LocateTolerance(m->mesh.diameter), weight)) continue;
      const PetscInt body = m->mesh.vertex_body[VertexOf(list, e, 0)];
      if (!full) {
        end->block = PetscMin(end->block, list->gid[e]);
        end->body = PetscMin(end->body, body), end->other_body = PetscMax(end->other_body, body);
        const PetscInt later = GroupIsBuilt(scene, m->materials.names[list->group[e]], 0)
                                   ? 0
                                   : m->materials.n_groups;
        end->group = PetscMin(end->group, list->group[e] + later);
        continue;
      }
      for (PetscInt k = 0; k < list->n_nodes; k++)
        end->gid[k] = m->mesh.vertex_gid[VertexOf(list, e, k)], end->weight[k] = weight[k];
    }
}

/* Collective. Finds the blocks at all ends in two rounds: the blocks, then their vertices. */
static PetscErrorCode find_ends(const Scene *scene, const Model *m, PetscInt n, const Anchor *anchors,
                                End *ends)
{
  PetscInt *least, *gid;
  PetscReal *weight;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(8 * n, &least, 8 * n, &gid, 8 * n, &weight));
  for (PetscInt i = 0; i < 2 * n; i++) {
    ends[i] = (End){PETSC_MAX_INT, PETSC_MAX_INT, -1, PETSC_MAX_INT, {-1, -1, -1, -1}, {0., 0., 0., 0.}};
    find_block(scene, m, end_of(anchors, i), PETSC_FALSE, ends + i);
    least[4 * i] = ends[i].block, least[4 * i + 1] = ends[i].body, least[4 * i + 2] = -ends[i].other_body,
              least[4 * i + 3] = ends[i].group;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, least, (PetscMPIInt)(8 * n), MPIU_INT, MPI_MIN, m->comm));
  for (PetscInt i = 0; i < 2 * n; i++) {
    ends[i].block = least[4 * i], ends[i].body = least[4 * i + 1], ends[i].other_body = -least[4 * i + 2],
    ends[i].group = least[4 * i + 3];
    find_block(scene, m, end_of(anchors, i), PETSC_TRUE, ends + i);
    for (int k = 0; k < 4; k++) gid[4 * i + k] = ends[i].gid[k], weight[4 * i + k] = ends[i].weight[k];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, gid, (PetscMPIInt)(8 * n), MPIU_INT, MPI_MAX, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, weight, (PetscMPIInt)(8 * n), MPIU_REAL, MPI_SUM, m->comm));
  for (PetscInt i = 0; i < 2 * n; i++)
    for (int k = 0; k < 4; k++) ends[i].gid[k] = gid[4 * i + k], ends[i].weight[k] = weight[4 * i + k];
  PetscCall(PetscFree3(least, gid, weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses an end in no block, an end between two bodies, and an anchor within one block. */
static void check_ends(const Scene *scene, const Model *m, PetscInt n, const Anchor *anchors, const End *ends,
                       char *message)
{
  for (PetscInt i = 0; i < 2 * n; i++) {
    const Anchor *of = anchors + i / 2;
    const PetscBool bonded = (PetscBool)(of->bond_stiffness > 0.),
                    holds = (PetscBool)(!bonded || (i % 2 == 0 && AnchorHasHead(of)));
    const PetscReal *point = end_of(anchors, i);
    char key[LABEL_LENGTH];
    snprintf(key, sizeof(key), "anchors.%s.%s", of->entry.name, i % 2 ? "root" : "head");
    if (ends[i].block == PETSC_MAX_INT)
      Complain(message, scene->file, of->entry.line, key, "(%g, %g) lies in no block of the mesh",
               (double)point[0], (double)point[1]);
    else if (holds && ends[i].body != ends[i].other_body)
      Complain(message, scene->file, of->entry.line, key,
               "(%g, %g) lies between two bodies: move it into the one that holds it", (double)point[0],
               (double)point[1]);
    else if (!bonded && i % 2 && ends[i].block == ends[i - 1].block)
      Complain(message, scene->file, of->entry.line, key, "head and root lie in one block");
    else if (holds)
      CheckBuilt(scene, of, m->materials.names[ends[i].group % m->materials.n_groups], key, message);
  }
}

/* ---- the anchors of this rank */

/* Finds the local numbers of the vertices in gids, sorted; -1: this rank does not know the vertex. */
static PetscErrorCode local_vertices(const Model *m, PetscInt n, const PetscInt *gids, PetscInt *local)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) local[i] = -1;
  for (PetscInt v = 0; v < m->mesh.n_owned + m->ghosts.n_element && n; v++) {
    PetscInt at;
    PetscCall(PetscFindInt(m->mesh.vertex_gid[v], n, gids, &at));
    if (at >= 0) local[at] = v;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ties the line to the blocks at its two ends. */
static PetscErrorCode tie_ends(const End ends[2], PetscInt n_gids, const PetscInt *gids,
                               const PetscInt *local, Line *line)
{
  PetscFunctionBeginUser;
  for (int e = 0; e < 2; e++)
    for (int k = 0; k < 4 && ends[e].gid[k] >= 0; k++) {
      PetscInt at;
      PetscCall(PetscFindInt(ends[e].gid[k], n_gids, gids, &at));
      line->vertex[line->n] = local[at], line->weight[line->n++] = e ? -ends[e].weight[k] : ends[e].weight[k];
    }
  for (int x = 0; x < 2; x++) line->reference[x] = line->of->head[x] - line->of->root[x];
  line->length = PetscHypotReal(line->reference[0], line->reference[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ties the line to the head and to the place where the free length ends. */
static void tie_chain(const Chain *c, Line *line)
{
  for (int e = 0; e < 2; e++) {
    const Place *place = c->place + e;
    for (PetscInt k = 0; k < place->n; k++) {
      line->vertex[line->n] = place->vertex[k];
      line->weight[line->n++] = e ? -place->weight[k] : place->weight[k];
    }
  }
  line->length = c->length[0];
  for (int x = 0; x < 2; x++) line->reference[x] = -c->length[0] * c->towards[x];
}

/* Decides whether this rank has vertices of the anchor; then it must know all of them. */
static PetscErrorCode find_here(const Model *m, Line *line)
{
  const PetscInt n = line->chain ? line->chain->n_vertices : line->n,
                 *vertex = line->chain ? line->chain->vertex : line->vertex;
  PetscBool all = PETSC_TRUE;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) {
    all = (PetscBool)(all && vertex[i] >= 0);
    line->here = (PetscBool)(line->here || (vertex[i] >= 0 && vertex[i] < m->mesh.n_owned));
  }
  PetscCheck(all || !line->here, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "anchor %s: a vertex of it is not known here", line->of->entry.name);
  line->mine = (PetscBool)(vertex[0] >= 0 && vertex[0] < m->mesh.n_owned);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode line_create(const Model *m, const Anchor *of, const End ends[2], PetscInt n_gids,
                                  const PetscInt *gids, const PetscInt *local, Line *line)
{
  PetscFunctionBeginUser;
  line->of = of;
  if (line->chain)
    tie_chain(line->chain, line);
  else
    PetscCall(tie_ends(ends, n_gids, gids, local, line));
  for (PetscInt i = line->n; i < LINE_VERTICES; i++) line->vertex[i] = line->vertex[0];
  PetscCall(find_here(m, line));
  line->stiffness = line->chain ? line->chain->k[0] : of->young * of->area / AnchorFree(of);
  line->T_y = of->yield * of->area;
  line->per_slice = m->materials.thickness / of->spacing;
  line->span = line->length;
  for (int x = 0; x < 2; x++) line->e[x] = line->reference[x] / line->length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode lines_create(const Model *m, const Anchor *anchors, const End *ends, Anchors *all)
{
  PetscInt *gids, *local, n = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(8 * all->n, &gids, 8 * all->n, &local));
  for (PetscInt i = 0; i < 2 * all->n; i++)
    for (int k = 0; k < 4; k++)
      if (ends[i].gid[k] >= 0) gids[n++] = ends[i].gid[k];
  PetscCall(PetscSortRemoveDupsInt(&n, gids));
  PetscCall(local_vertices(m, n, gids, local));
  for (PetscInt i = 0; i < all->n; i++)
    PetscCall(line_create(m, anchors + i, ends + 2 * i, n, gids, local, all->line + i));
  PetscCall(PetscFree2(gids, local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the pieces and dowels of bonded bars. */
static PetscErrorCode report_chains(const Model *m, const Anchors *all)
{
  PetscFunctionBeginUser;
  for (const Line *line = all->line; line < all->line + all->n; line++) {
    const Chain *c = line->chain;
    char dowels[160] = "";
    if (!c) continue;
    if (c->n_dowels)
      snprintf(dowels, sizeof dowels, ", a dowel across %d joints: %.4g MN/m, %.4g kN", (int)c->n_dowels,
               1e-6 * (double)c->dowel[0].K, 1e-3 * (double)c->dowel[0].V_y);
    PetscCall(PetscPrintf(m->comm, "anchor %-12s bonded in %d pieces of at most %.3g m%s\n",
                          line->of->entry.name, (int)(c->n - c->head), (double)AnchorSegment(line->of),
                          dowels));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Computes the fraction of each anchor that runs inside blocks, (n,), from PLACES points. An
   anchor along the edge of two blocks is in both. */
static PetscErrorCode parts_inside(const Model *m, PetscInt n, const Anchor *anchors, PetscReal *inside)
{
  enum { PLACES = 200 };
  signed char *is_inside; /* (n, PLACES) */
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(PLACES * n, &is_inside));
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++)
      for (PetscInt i = 0; i < n && list->owned[e]; i++) {
        PetscReal X[8], t[2];
        PetscInt leaves;
        for (PetscInt k = 0; k < 2 * list->n_nodes; k++)
          X[k] = m->mesh.X[2 * VertexOf(list, e, k / 2) + k % 2];
        if (!LocateLine(list->n_nodes, X, anchors[i].head, anchors[i].root, LocateTolerance(m->mesh.diameter),
                        t, &leaves))
          continue;
        for (PetscInt k = 0; k < PLACES; k++)
          if ((k + 0.5) / PLACES >= t[0] && (k + 0.5) / PLACES <= t[1]) is_inside[PLACES * i + k] = 1;
      }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, is_inside, (PetscMPIInt)(PLACES * n), MPI_SIGNED_CHAR, MPI_MAX, m->comm));
  for (PetscInt i = 0; i < n; i++) {
    PetscInt count = 0;
    for (PetscInt k = 0; k < PLACES; k++) count += is_inside[PLACES * i + k];
    inside[i] = (PetscReal)count / PLACES;
  }
  PetscCall(PetscFree(is_inside));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of a bonded bar with too long pieces. The bond takes the force over the length sqrt(E A / bond
   stiffness); pieces of fraction p of this length make the largest force p^2/8 too small. */
static void warn_segment(const Anchor *of)
{
  static const PetscReal ERROR = 0.02;
  const PetscReal over = PetscSqrtReal(of->young * of->area / of->bond_stiffness),
                  part = AnchorSegment(of) / over, error = 0.125 * part * part;
  if (error <= ERROR) return;
  Warn("anchors.%s.segment: pieces of %.3g m are %.2g of the length over which the bond "
       "takes the force, %.3g m: the force is about %.0f %% off; expected at most %.2g m",
       of->entry.name, (double)AnchorSegment(of), (double)part, (double)over,
       100. * PetscMin((double)error, 1.), (double)(0.4 * over));
}

/* Collective. Warns once a run of anchors that do not act as a user expects. */
static PetscErrorCode warn_unusual(const Model *m, PetscInt n, const Anchor *anchors, const End *ends)
{
  static const PetscReal AIR =
      0.01; // fraction of the length that may run outside blocks: a gallery, an open joint
  static PetscInt runs;
  PetscReal *inside;
  PetscFunctionBeginUser;
  if (AlreadyWarned(&runs)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(n, &inside));
  PetscCall(parts_inside(m, n, anchors, inside));
  for (PetscInt i = 0; i < n && !m->rank; i++) {
    const Anchor *of = anchors + i;
    const PetscReal air = (1. - inside[i]) * AnchorLength(of);
    if (of->bond_stiffness > 0.) warn_segment(of);
    if (of->bond_stiffness > 0.) continue;
    if (ends[2 * i].body == ends[2 * i + 1].body)
      Warn("anchors.%s: head and root lie in one body: it holds no joint together", of->entry.name);
    if (air > AIR * AnchorLength(of))
      Warn("anchors.%s: %.3g of its %.4g m run outside all blocks, through air", of->entry.name, (double)air,
           (double)AnchorLength(of));
  }
  PetscCall(PetscFree(inside));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsCreate(const TermView *v, void **memory)
{
  char message[MESSAGE_LENGTH] = "";
  PetscInt n;
  const Anchor *anchors = SceneEntries(v->scene, "anchors", &n);
  Anchors *all;
  Chain **chains;
  End *ends;
  PetscFunctionBeginUser;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(2 * n, &ends, n, &chains));
  PetscCall(find_ends(v->scene, v->m, n, anchors, ends));
  check_ends(v->scene, v->m, n, anchors, ends, message);
  PetscCall(ChainsCreate(v->scene, v->m, n, anchors, chains, message));
  for (PetscInt i = 0; i < n && message[0]; i++) PetscCall(ChainDestroy(chains + i));
  if (message[0]) PetscCall(PetscFree2(ends, chains));
  PetscCall(CheckMessage(v->m->comm, message));
  PetscCall(warn_unusual(v->m, n, anchors, ends));
  PetscCall(PetscNew(&all));
  all->n = n;
  PetscCall(PetscCalloc1(n, &all->line));
  for (PetscInt i = 0; i < n; i++) all->line[i].chain = chains[i];
  PetscCall(lines_create(v->m, anchors, ends, all));
  PetscCall(PetscFree2(ends, chains));
  *memory = all;
  if (!v->state->cycle) PetscCall(report_chains(v->m, all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsDestroy(const Scene *scene, void **memory)
{
  Anchors *all = *memory;
  PetscFunctionBeginUser;
  (void)scene;
  if (all) {
    for (PetscInt i = 0; i < all->n; i++) PetscCall(ChainDestroy(&all->line[i].chain));
    PetscCall(PetscFree(all->line));
    PetscCall(PetscFree(all->report));
    PetscCall(PetscFree(all->name));
    PetscCall(PetscFree(all->checked));
  }
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}
