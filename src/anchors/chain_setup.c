/* chain_setup.c: finds the path of a bonded bar through blocks, and divides it into pieces.

   All ranks get all passages of all bars through blocks. A stretch is the length of a bar in one body
   without a gap. Each stretch is divided into equal pieces, whose middles are the places; so joints lie
   between places. */
#include "anchors/chain.h"

PetscBool AnchorHasHead(const Anchor *a)
{
  return (PetscBool)(a->free_length > 0. || a->plate);
}

/* Returns whether the anchor is stressed or installed in stage s. */
static PetscBool begins_in(const Scene *scene, const Anchor *a, PetscInt s)
{
  const Stage *stage = scene->stages + s;
  if (AnchorIsPulled(stage, a) || !strcmp(a->from, stage->name)) return PETSC_TRUE;
  for (PetscInt i = 0; i < a->n_locks; i++)
    if (!strcmp(a->lock[i], stage->name)) return PETSC_TRUE;
  return (PetscBool)(!a->n_forces && !a->from[0] && StageBase(scene, s) < 0);
}

PetscBool GroupIsBuilt(const Scene *scene, const char *group, PetscInt stage)
{
  PetscBool any = PETSC_FALSE;
  for (PetscInt s = 0; s < scene->n_stages; s++)
    any = (PetscBool)(any || NameRow(scene->stages[s].n_build, scene->stages[s].build, group) >= 0);
  while (any && stage >= 0 && NameRow(scene->stages[stage].n_build, scene->stages[stage].build, group) < 0)
    stage = StageBase(scene, stage);
  return (PetscBool)(!any || stage >= 0);
}

/* The part of a bar in one block, as all ranks know it. */
typedef struct {
  PetscInt anchor, gid, body, leaves, n, group; /* leaves: face through which the bar leaves: LocateLine */
  PetscInt vertex[4];
  PetscReal t[2], X[8]; /* positions along the bar from head to root, 0 to 1 */
} Passage;
enum { PASSAGE_INTS = 6, PASSAGE_NUMBERS = PASSAGE_INTS + 4 + 2 + 8 };

/* A stretch of a bar in one body. */
typedef struct {
  PetscInt body, pieces;
  PetscReal a, b; /* [m] from the head */
} Stretch;

/* Path of one bar. */
typedef struct {
  const Anchor *of;
  PetscInt n_parts, n_stretches;
  const Passage *part; /* sorted by their starts */
  Stretch *stretch;
  PetscReal tolerance; /* [m] */
} Way;

/* ---- the parts */

static void to_numbers(const Passage *part, PetscReal *x)
{
  const PetscInt whole[PASSAGE_INTS] = {part->anchor, part->gid, part->body,
                                        part->leaves, part->n,   part->group};
  for (int i = 0; i < PASSAGE_INTS; i++) *x++ = (PetscReal)whole[i];
  for (int k = 0; k < 4; k++) *x++ = (PetscReal)part->vertex[k];
  for (int k = 0; k < 2; k++) *x++ = part->t[k];
  for (int k = 0; k < 8; k++) *x++ = part->X[k];
}

static Passage from_numbers(const PetscReal *x)
{
  Passage part = {.anchor = (PetscInt)x[0],
                  .gid = (PetscInt)x[1],
                  .body = (PetscInt)x[2],
                  .leaves = (PetscInt)x[3],
                  .n = (PetscInt)x[4],
                  .group = (PetscInt)x[5]};
  x += PASSAGE_INTS;
  for (int k = 0; k < 4; k++) part.vertex[k] = (PetscInt)*x++;
  for (int k = 0; k < 2; k++) part.t[k] = *x++;
  for (int k = 0; k < 8; k++) part.X[k] = *x++;
  return part;
}

/* Finds the passages in the blocks that this rank owns. */
static PetscErrorCode own_parts(const Model *m, PetscInt n, const Anchor *anchors, PetscSegBuffer buffer)
{
  PetscFunctionBeginUser;
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++)
      for (PetscInt i = 0; i < n && list->owned[e]; i++) {
        Passage part = {.anchor = i, .gid = list->gid[e], .n = list->n_nodes};
        PetscReal *to;
        if (!(anchors[i].bond_stiffness > 0.)) continue;
        for (PetscInt k = 0; k < 2 * part.n; k++) part.X[k] = m->mesh.X[2 * VertexOf(list, e, k / 2) + k % 2];
        if (!LocateLine(part.n, part.X, anchors[i].head, anchors[i].root, LocateTolerance(m->mesh.diameter),
                        part.t, &part.leaves))
          continue;
        for (PetscInt k = 0; k < part.n; k++) part.vertex[k] = m->mesh.vertex_gid[VertexOf(list, e, k)];
        part.body = m->mesh.vertex_body[VertexOf(list, e, 0)];
        part.group = list->group[e];
        PetscCall(PetscSegBufferGet(buffer, PASSAGE_NUMBERS, &to));
        to_numbers(&part, to);
      }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int by_place(const void *a, const void *b)
{
  const Passage *p = a, *q = b;
  if (p->anchor != q->anchor) return p->anchor < q->anchor ? -1 : 1;
  if (p->t[0] != q->t[0]) return p->t[0] < q->t[0] ? -1 : 1;
  return p->gid < q->gid ? -1 : p->gid > q->gid;
}

/* Collective. Gathers the passages of all bars, sorted. */
static PetscErrorCode all_parts(const Model *m, PetscInt n, const Anchor *anchors, PetscInt *n_parts,
                                Passage **parts)
{
  PetscSegBuffer buffer;
  size_t count;
  PetscMPIInt mine, *counts, *starts, total = 0;
  PetscReal *own, *all;
  PetscFunctionBeginUser;
  PetscCall(PetscSegBufferCreate(sizeof(PetscReal), 64 * PASSAGE_NUMBERS, &buffer));
  PetscCall(own_parts(m, n, anchors, buffer));
  PetscCall(PetscSegBufferGetSize(buffer, &count));
  PetscCall(PetscSegBufferExtractAlloc(buffer, &own));
  PetscCall(PetscMPIIntCast((PetscInt)count, &mine));
  PetscCall(PetscMalloc2(m->size, &counts, m->size, &starts));
  PetscCallMPI(MPI_Allgather(&mine, 1, MPI_INT, counts, 1, MPI_INT, m->comm));
  for (PetscMPIInt r = 0; r < m->size; r++) starts[r] = total, total += counts[r];
  PetscCall(PetscMalloc1(total, &all));
  PetscCallMPI(MPI_Allgatherv(own, mine, MPIU_REAL, all, counts, starts, MPIU_REAL, m->comm));
  *n_parts = total / PASSAGE_NUMBERS;
  PetscCall(PetscMalloc1(*n_parts, parts));
  for (PetscInt i = 0; i < *n_parts; i++) (*parts)[i] = from_numbers(all + PASSAGE_NUMBERS * i);
  if (*n_parts) qsort(*parts, (size_t)*n_parts, sizeof(Passage), by_place);
  PetscCall(PetscFree(own));
  PetscCall(PetscFree(all));
  PetscCall(PetscFree2(counts, starts));
  PetscCall(PetscSegBufferDestroy(&buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stretches */

/* Finds the stretches; way->stretch has room for one per passage. Returns the distance [m] from the head
   at which two bodies share the bar, < 0: nowhere. */
static PetscReal find_stretches(Way *way)
{
  const PetscReal length = AnchorLength(way->of), from = way->of->free_length;
  way->n_stretches = 0;
  for (const Passage *p = way->part; p < way->part + way->n_parts; p++) {
    const PetscReal a = PetscMax(from, p->t[0] * length), b = p->t[1] * length;
    Stretch *last = way->stretch + way->n_stretches - 1;
    if (b - a <= way->tolerance) continue;
    if (way->n_stretches && a < last->b + way->tolerance && p->body == last->body) {
      last->b = PetscMax(last->b, b);
      continue;
    }
    if (way->n_stretches && a < last->b - PetscMax(way->tolerance, 0.01 * (b - a))) return a;
    way->stretch[way->n_stretches++] = (Stretch){.body = p->body, .a = a, .b = b};
  }
  for (Stretch *s = way->stretch; s < way->stretch + way->n_stretches; s++)
    s->pieces = PetscMax(2, (PetscInt)PetscCeilReal((s->b - s->a) / AnchorSegment(way->of) - 1e-9));
  return -1.;
}

/* Decides whether a dowel has joints to act across; what receives why not. */
static PetscBool has_joints(const Way *way, PetscReal widest, char *what, size_t size)
{
  if (way->n_stretches < 2) snprintf(what, size, "a dowel needs a joint: the bonded length lies in one body");
  for (PetscInt i = 0; i + 1 < way->n_stretches; i++) {
    const PetscReal gap = way->stretch[i + 1].a - way->stretch[i].b;
    if (gap > widest)
      snprintf(what, size, "the bar crosses a gap of %g m, %g m from its head: a dowel needs a joint there",
               (double)gap, (double)way->stretch[i].b);
  }
  return (PetscBool)!what[0];
}

void CheckBuilt(const Scene *scene, const Anchor *of, const char *group, const char *key, char *message)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (begins_in(scene, of, s) && !GroupIsBuilt(scene, group, s))
      Complain(message, scene->file, of->entry.line, key,
               "the group %s, which holds it, is not built yet in stage %s, from which on it is there", group,
               scene->stages[s].name);
}

static void check_way(const Scene *scene, const Model *m, const Way *way, PetscReal shared, char *message)
{
  char what[LABEL_LENGTH] = "", key[LABEL_LENGTH];
  PetscReal K, V_y;
  AnchorDowel(way->of, &K, &V_y);
  if (shared >= 0.)
    snprintf(what, sizeof what, "%g m from its head the bar runs along a joint, in two bodies",
             (double)shared);
  else if (!way->n_stretches)
    snprintf(what, sizeof what, "no block holds its bonded length");
  else if (K > 0.)
    (void)has_joints(way, PetscMax(m->contact_margin, way->tolerance), what, sizeof what);
  snprintf(key, sizeof key, "anchors.%s", way->of->entry.name);
  if (what[0]) Complain(message, scene->file, way->of->entry.line, key, "%s", what);
  for (const Passage *p = way->part; p < way->part + way->n_parts; p++) {
    const PetscReal length = AnchorLength(way->of), from = PetscMax(way->of->free_length, p->t[0] * length);
    if (p->t[1] * length - from > way->tolerance)
      CheckBuilt(scene, way->of, m->materials.names[p->group], key, message);
  }
}

/* ---- places */

/* Returns a place in a block. Its vertices are gids until the chain is known. */
static Place place_in(const Passage *part, const PetscReal point[2], PetscReal tolerance)
{
  Place place = {.n = part->n};
  if (!LocateInBlock(part->n, part->X, point, tolerance, place.weight)) place.n = 0;
  for (PetscInt k = 0; k < place.n; k++) place.vertex[k] = part->vertex[k];
  return place;
}

/* Returns the place `at` metres from the head in the lowest block of a body; body < 0: of any. part
   receives its passage. */
static Place place_at(const Way *way, PetscReal at, PetscInt body, PetscReal tolerance, const Passage **part)
{
  const Anchor *of = way->of;
  const PetscReal t = at / AnchorLength(of);
  const PetscReal point[2] = {of->head[0] + t * (of->root[0] - of->head[0]),
                              of->head[1] + t * (of->root[1] - of->head[1])};
  Place best = {.n = 0};
  *part = NULL;
  for (const Passage *p = way->part; p < way->part + way->n_parts; p++) {
    if ((body >= 0 && p->body != body) || (*part && p->gid > (*part)->gid)) continue;
    const Place place = place_in(p, point, tolerance);
    if (place.n) best = place, *part = p;
  }
  return best;
}

/* Returns the dowel at the joint behind stretch s. */
static Dowel dowel_behind(const Way *way, PetscInt s, PetscInt piece, PetscReal tolerance)
{
  const Stretch *before = way->stretch + s, *behind = before + 1;
  const PetscReal length = AnchorLength(way->of), gap = behind->a - before->b;
  const Passage *part[2], *last = NULL;
  Dowel d = {.piece = piece};
  d.on[0] = place_at(way, before->b, before->body, tolerance, part);
  d.on[1] = place_at(way, behind->a, behind->body, tolerance, part + 1);
  AnchorDowel(way->of, &d.K, &d.V_y);
  for (const Passage *p = way->part; p < way->part + way->n_parts; p++) // the block that the bar leaves there
    if (p->body == before->body && p->leaves >= 0 && (!last || p->t[1] > last->t[1]) &&
        p->t[1] * length < before->b + way->tolerance)
      last = p;
  if (!last) last = part[0];
  const PetscInt k = PetscMax(0, last->leaves), ends[2] = {(k + 1) % last->n, k};
  d.face = (Place){.n = 2, .weight = {1., -1.}};
  for (int i = 0; i < 2; i++) d.face.vertex[i] = last->vertex[ends[i]];
  for (int x = 0; x < 2; x++) d.along[x] = last->X[2 * ends[0] + x] - last->X[2 * ends[1] + x];
  d.face_length = PetscHypotReal(d.along[0], d.along[1]);
  for (int x = 0; x < 2; x++) d.along[x] /= d.face_length, d.t[x] = d.along[x];
  for (int x = 0; x < 2; x++) d.gap[x] = gap * (way->of->root[x] - way->of->head[x]) / length;
  d.length = d.face_length;
  return d;
}

/* ---- the chain */

static PetscErrorCode allocate(PetscInt n, PetscInt n_dowels, Chain *c)
{
  PetscFunctionBeginUser;
  c->n = n, c->n_dowels = n_dowels;
  c->n_numbers = 2 * (n - 1) + 2 * n + 2 * n_dowels + CHAIN_LOSSES;
  PetscCall(
      PetscCalloc7(n, &c->place, n, &c->from, n, &c->bonded, n, &c->c, n, &c->B, n, &c->length, n, &c->k));
  PetscCall(PetscCalloc6(2 * n, &c->towards, n_dowels, &c->dowel, n, &c->crossing, n, &c->g, 2 * n, &c->e, n,
                         &c->span));
  PetscCall(
      PetscCalloc6(n, &c->N, n, &c->b, n, &c->k_now, n, &c->c_now, 2 * n, &c->branch, 2 * n, &c->before));
  PetscCall(PetscCalloc5(n, &c->r, n, &c->step, n, &c->pivot, n, &c->try, n, &c->elastic));
  for (int i = 0; i < CHAIN_STATES; i++) {
    PetscReal *x;
    ChainMemory *of = c->memory + i;
    PetscCall(PetscCalloc1(c->n_numbers, &x));
    c->numbers[i] = x;
    of->natural = x, of->plastic = x += n - 1;
    of->slid = x += n - 1, of->slip = x += n;
    of->upright = x += n, of->sheared = x += n_dowels, of->lost = x + n_dowels;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets places, lengths and stiffnesses of the chain. */
static void lay_out(const Way *way, PetscReal tolerance, Chain *c)
{
  const Anchor *of = way->of;
  const Passage *part;
  PetscInt i = 0, dowel = 0;
  if (c->head) c->place[i++] = place_at(way, 0., -1, tolerance, &part);
  for (PetscInt s = 0; s < way->n_stretches; s++) {
    const Stretch *stretch = way->stretch + s;
    const PetscReal h = (stretch->b - stretch->a) / (PetscReal)stretch->pieces;
    if (s && c->n_dowels) c->dowel[dowel] = dowel_behind(way, s - 1, i - 1, tolerance), dowel++;
    for (PetscInt k = 0; k < stretch->pieces; k++, i++) {
      c->from[i] = stretch->a + ((PetscReal)k + 0.5) * h;
      c->place[i] = place_at(way, c->from[i], stretch->body, tolerance, &part);
      c->bonded[i] = h, c->c[i] = of->bond_stiffness * h, c->B[i] = of->bond_strength * h;
    }
  }
  for (PetscInt j = 0; j < c->n; j++) c->crossing[j] = -1;
  for (PetscInt d = 0; d < c->n_dowels; d++) c->crossing[c->dowel[d].piece] = d;
  for (PetscInt j = 0; j + 1 < c->n; j++) {
    c->length[j] = c->from[j + 1] - c->from[j], c->k[j] = c->EA / c->length[j];
    for (int x = 0; x < 2; x++) c->towards[2 * j + x] = (of->root[x] - of->head[x]) / AnchorLength(of);
    for (int x = 0; x < 2; x++) c->e[2 * j + x] = c->towards[2 * j + x];
    c->span[j] = c->length[j];
  }
}

/* Replaces the gids of a place by local numbers and by rows of the chain's list of vertices. */
static PetscErrorCode number(const PetscInt *gids, PetscInt n, const PetscInt *local, Place *place)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < PLACE_VERTICES; k++) {
    if (k < place->n) PetscCall(PetscFindInt(place->vertex[k], n, gids, place->at + k));
    if (k >= place->n) place->at[k] = place->at[0];
    place->vertex[k] = local[place->at[k]];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the vertices of the chain in the order of their gids, with their local numbers. */
static PetscErrorCode find_vertices(const Model *m, Chain *c)
{
  PetscInt n = 0, *gids;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(4 * c->n + 10 * c->n_dowels, &gids));
  for (PetscInt i = 0; i < c->n; i++)
    for (PetscInt k = 0; k < c->place[i].n; k++) gids[n++] = c->place[i].vertex[k];
  for (PetscInt d = 0; d < c->n_dowels; d++) {
    const Place *of[3] = {&c->dowel[d].on[0], &c->dowel[d].on[1], &c->dowel[d].face};
    for (int i = 0; i < 3; i++)
      for (PetscInt k = 0; k < of[i]->n; k++) gids[n++] = of[i]->vertex[k];
  }
  PetscCall(PetscSortRemoveDupsInt(&n, gids));
  PetscCall(PetscMalloc1(n, &c->vertex));
  c->n_vertices = n;
  for (PetscInt i = 0; i < n; i++) c->vertex[i] = -1;
  for (PetscInt v = 0; v < m->mesh.n_owned + m->ghosts.n_element; v++) {
    PetscInt at;
    PetscCall(PetscFindInt(m->mesh.vertex_gid[v], n, gids, &at));
    if (at >= 0) c->vertex[at] = v;
  }
  for (PetscInt i = 0; i < c->n; i++) PetscCall(number(gids, n, c->vertex, c->place + i));
  for (Dowel *d = c->dowel; d < c->dowel + c->n_dowels; d++) {
    PetscCall(number(gids, n, c->vertex, &d->on[0]));
    PetscCall(number(gids, n, c->vertex, &d->on[1]));
    PetscCall(number(gids, n, c->vertex, &d->face));
  }
  PetscCall(PetscFree(gids));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode chain_create(const Model *m, const Way *way, Chain **chain)
{
  const Anchor *of = way->of;
  PetscReal K, V_y;
  PetscInt n = AnchorHasHead(of);
  Chain *c;
  PetscFunctionBeginUser;
  AnchorDowel(of, &K, &V_y);
  for (PetscInt s = 0; s < way->n_stretches; s++) n += way->stretch[s].pieces;
  PetscCall(PetscNew(&c));
  PetscCall(allocate(n, K > 0. ? way->n_stretches - 1 : 0, c));
  c->head = AnchorHasHead(of), c->turns = (PetscBool)(m->materials.strain == STRAIN_LARGE);
  c->slack = (PetscBool)(of->free_length > 0. && !of->compression);
  c->T_y = of->yield * of->area, c->EA = of->young * of->area, c->jack = -1.;
  lay_out(way, LocateTolerance(m->mesh.diameter), c);
  PetscCall(find_vertices(m, c));
  ChainPrepare(c);
  c->reach = ChainReach(c, AnchorStrength(of));
  *chain = c;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ChainsCreate(const Scene *scene, const Model *m, PetscInt n, const Anchor *anchors,
                            Chain **chains, char *message)
{
  PetscInt n_parts = 0, at = 0, bonded = 0;
  Passage *parts = NULL;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) chains[i] = NULL, bonded += anchors[i].bond_stiffness > 0.;
  if (!bonded) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(all_parts(m, n, anchors, &n_parts, &parts));
  for (PetscInt i = 0; i < n; i++) {
    Way way = {.of = anchors + i, .part = parts + at, .tolerance = LocateTolerance(m->mesh.diameter)};
    while (at < n_parts && parts[at].anchor == i) at++, way.n_parts++;
    if (!(anchors[i].bond_stiffness > 0.)) continue;
    PetscCall(PetscMalloc1(way.n_parts, &way.stretch));
    check_way(scene, m, &way, find_stretches(&way), message);
    if (!message[0]) PetscCall(chain_create(m, &way, chains + i));
    PetscCall(PetscFree(way.stretch));
  }
  PetscCall(PetscFree(parts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ChainDestroy(Chain **chain)
{
  Chain *c = *chain;
  PetscFunctionBeginUser;
  if (!c) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree7(c->place, c->from, c->bonded, c->c, c->B, c->length, c->k));
  PetscCall(PetscFree6(c->towards, c->dowel, c->crossing, c->g, c->e, c->span));
  PetscCall(PetscFree6(c->N, c->b, c->k_now, c->c_now, c->branch, c->before));
  PetscCall(PetscFree5(c->r, c->step, c->pivot, c->try, c->elastic));
  for (int i = 0; i < CHAIN_STATES; i++) PetscCall(PetscFree(c->numbers[i]));
  PetscCall(PetscFree(c->vertex));
  PetscCall(PetscFree(c->report));
  PetscCall(PetscFree(*chain));
  PetscFunctionReturn(PETSC_SUCCESS);
}
