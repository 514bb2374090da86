/* plausible.c: warns of combinations of loads and mesh that no dam has. Rank 0, once a run. */
#include "run/run.h"
#include <ctype.h>

/* Faces under pressure from the water, or ice, of a load. */
typedef struct {
  PetscReal push;      /* [m2] horizontal force over its unit weight; > 0: to the right */
  PetscReal low, high; /* [m] elevations of its faces */
} Pressed;

static const FaceSet *set_of(const BlockMesh *mesh, const char *name)
{
  for (PetscInt s = 0; s < mesh->n_face_sets; s++)
    if (!strcmp(mesh->face_sets[s].name, name)) return mesh->face_sets + s;
  return NULL;
}

static const PetscReal *corner_of(const BlockMesh *mesh, PetscInt block, PetscInt k)
{
  const PetscInt *corners = mesh->blocks + 4 * block;
  return mesh->X + 2 * corners[k % BlockCorners(corners)];
}

/* Sums the thrust of a pressure that grows with the depth below the level; for ice, over the faces at its
   level. */
static Pressed pressed_by(const BlockMesh *mesh, const Load *load)
{
  const FaceSet *set = set_of(mesh, load->target);
  Pressed p = {.low = PETSC_INFINITY, .high = PETSC_NINFINITY};
  for (PetscInt i = 0; set && i < set->n; i++) {
    const PetscReal *a = corner_of(mesh, set->faces[2 * i], set->faces[2 * i + 1]),
                    *b = corner_of(mesh, set->faces[2 * i], set->faces[2 * i + 1] + 1);
    const PetscReal low = PetscMin(a[1], b[1]), high = PetscMax(a[1], b[1]);
    const PetscReal wet = PetscMax(0., PetscMin(high, load->level) - low), sign = b[1] < a[1] ? 1. : -1.;
    p.low = PetscMin(p.low, low), p.high = PetscMax(p.high, high);
    if (load->kind == LOAD_ICE)
      p.push += low <= load->level && load->level <= high && high > low ? sign : 0.;
    else
      p.push += sign * wet * PetscMax(0., load->level - low - 0.5 * wet);
  }
  return p;
}

static PetscBool is_free_water(const Load *load)
{
  return (PetscBool)(load->kind == LOAD_RESERVOIR || load->kind == LOAD_OVERFLOW ||
                     load->kind == LOAD_TAILWATER);
}

/* Decides whether a load belongs to a reservoir, which must press on the same side. */
static PetscBool comes_with_water(const Load *load)
{
  return (PetscBool)(load->kind == LOAD_ICE || load->kind == LOAD_SILT || load->kind == LOAD_WAVE ||
                     load->kind == LOAD_PSEUDO_STATIC || load->kind == LOAD_ADDED_MASS);
}

/* Warns of a load that comes with water, at faces where no water of the stage presses, and of silt or ice at
   a level that its water excludes. */
static void doubt_water_beside(const Scene *scene, const BlockMesh *mesh, PetscInt l, const Stage *stage)
{
  const PetscReal near = 3.;  // [m] from the surface: ice is 1 m thick, and levels change
  const PetscReal thin = 0.1; // [m] of silt
  const Load *load = scene->loads + l;
  const PetscReal push = pressed_by(mesh, load).push;
  const Load *water = NULL;
  PetscBool any = PETSC_FALSE, beside = PETSC_FALSE;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const Load *other = scene->loads + stage->loads[i];
    if (!is_free_water(other)) continue;
    const PetscReal of_other = pressed_by(mesh, other).push;
    any = (PetscBool)(any || of_other != 0.); // a water below all its faces does not press
    if (of_other * push <= 0.) continue;
    beside = PETSC_TRUE;
    if (!water || PetscAbsReal(other->level - load->level) < PetscAbsReal(water->level - load->level))
      water = other;
  }
  const PetscBool moves_water = (PetscBool)(load->kind == LOAD_PSEUDO_STATIC ||
                                            load->kind == LOAD_ADDED_MASS);
  if (any && push != 0. && !beside && moves_water)
    Warn("stages.%s: loads.%s shakes water at the faces '%s', where no water of the stage "
         "stands: expected the faces on which the water stands",
         stage->name, load->name, load->target);
  else if (any && push != 0. && !beside)
    Warn("stages.%s: loads.%s pushes to the %s, where no water of the stage pushes: expected "
         "the faces on which the water stands",
         stage->name, load->name, push > 0. ? "right" : "left");
  else if (load->kind == LOAD_SILT && water && load->level > water->level + thin)
    Warn("stages.%s: loads.%s: its level is %.6g m, but the water of loads.%s stands at "
         "%.6g m: density is what silt weighs in water, and above it silt weighs more",
         stage->name, load->name, (double)load->level, water->name, (double)water->level);
  else if (load->kind == LOAD_ICE && water && PetscAbsReal(water->level - load->level) > near)
    Warn("stages.%s: loads.%s: its level is %.6g m, but the water of loads.%s stands at "
         "%.6g m: "
         "expected ice at the surface",
         stage->name, load->name, (double)load->level, water->name, (double)water->level);
}

/* Decides whether the level of a load is a level of free water. */
static PetscBool follows_level(const Load *load)
{
  return (PetscBool)(load->kind == LOAD_UPLIFT || load->kind == LOAD_ADDED_MASS ||
                     (load->kind == LOAD_PSEUDO_STATIC && load->target[0]));
}

/* Warns of an uplift, or of shaken water, whose level is far below the water of its stage: it is on the
   unsafe side. */
static void doubt_lower_water(const Scene *scene, const BlockMesh *mesh, PetscInt l, const Stage *stage)
{
  const PetscReal part = 0.1; // of the depth: drained rock and rounded levels are below
  const Load *load = scene->loads + l, *water = NULL;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const Load *other = stage->loads[i] < 0 ? NULL : scene->loads + stage->loads[i];
    if (other && is_free_water(other) && pressed_by(mesh, other).push != 0. &&
        (!water || PetscAbsReal(other->level - load->level) < PetscAbsReal(water->level - load->level)))
      water = other; // the nearest to this level
  }
  if (!water || water->level - load->level <= part * (water->level - pressed_by(mesh, water).low)) return;
  Warn("stages.%s: loads.%s.level: %.6g m, but the water of loads.%s stands at %.6g m: "
       "expected the level of the water of the stage",
       stage->name, load->name, (double)load->level, water->name, (double)water->level);
}

/* Returns whether a word is in a name, in any case of letters. */
static PetscBool has_word(const char *name, const char *word)
{
  const size_t n = strlen(word);
  for (; *name; name++) {
    size_t k = 0;
    while (k < n && tolower((unsigned char)name[k]) == word[k]) k++;
    if (k == n) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Warns where the highest water of a stage stands at faces with a name for downstream. */
static void doubt_side(const Scene *scene, const Stage *stage)
{
  const Load *highest = NULL;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const Load *load = scene->loads + stage->loads[i];
    if (is_free_water(load) && (!highest || load->level > highest->level)) highest = load;
  }
  if (!highest || highest->kind == LOAD_TAILWATER) return;
  if (!has_word(highest->target, "downstream") && !has_word(highest->target, "jusante")) return;
  Warn("stages.%s: the highest water, loads.%s at %.6g m, stands at the faces '%s': "
       "expected the "
       "reservoir upstream",
       stage->name, highest->name, (double)highest->level, highest->target);
}

/* Warns where two loads of a stage put water on one set of faces, or into one joint: it presses twice. A
   second water of another density stands for silt. */
static void doubt_twice(const Scene *scene, const Stage *stage)
{
  for (PetscInt i = 0; i < stage->n_loads; i++)
    for (PetscInt j = 0; j < i; j++) {
      if (stage->loads[i] < 0 || stage->loads[j] < 0) continue;
      const Load *a = scene->loads + stage->loads[j], *b = scene->loads + stage->loads[i];
      const PetscBool free = (PetscBool)(is_free_water(a) && is_free_water(b)),
                      inside = (PetscBool)(a->kind == LOAD_UPLIFT && b->kind == LOAD_UPLIFT);
      if ((!free && !inside) || strcmp(a->target, b->target) || a->density != b->density) continue;
      Warn("stages.%s: loads.%s and loads.%s both %s '%s': water there counts twice", stage->name, a->name,
           b->name, free ? "press on" : "are in", a->target);
    }
}

/* Warns of a gallery above the water of the dam: its drain would give water to the joints. */
static void doubt_gallery(const Scene *scene, const Load *load)
{
  PetscReal highest = load->kind == LOAD_UPLIFT ? load->level : PETSC_NINFINITY;
  for (PetscInt l = 0; l < scene->n_loads && load->kind == LOAD_DRAIN; l++)
    if (is_free_water(scene->loads + l) || scene->loads[l].kind == LOAD_HEAD)
      highest = PetscMax(highest, scene->loads[l].level);
  if (!(load->uplift.gallery > highest)) return;
  Warn("loads.%s.gallery: %.6g m is above the water, which stands at %.6g m: expected the "
       "elevation at which the drain opens",
       load->name, (double)load->uplift.gallery, (double)highest);
}

/* Warns of a mesh far larger than a dam. No masonry dam is higher than 300 m; with three heights of rock
   below it the mesh has 1200 m. */
static void doubt_size(const Scene *scene, const BlockMesh *mesh)
{
  const PetscReal most[2] = {6000., 1500.}, least = 0.03; // [m] width, height; of models in a laboratory
  PetscReal low[2] = {PETSC_INFINITY, PETSC_INFINITY}, high[2] = {PETSC_NINFINITY, PETSC_NINFINITY};
  for (PetscInt i = 0; i < 2 * mesh->n_vertices; i++)
    low[i % 2] = PetscMin(low[i % 2], mesh->X[i]), high[i % 2] = PetscMax(high[i % 2], mesh->X[i]);
  const PetscReal width = high[0] - low[0], height = high[1] - low[1];
  if (width <= most[0] && height <= most[1] && PetscMax(width, height) >= least) return;
  Warn("%s: the mesh is %.4g m wide and %.4g m high: expected metres; a drawing in mm has a "
       "thousand times as much",
       scene->model, (double)width, (double)height);
}

/* Warns of a level far below or far above its faces: it is likely to be in another unit or datum. */
static void doubt_level(const BlockMesh *mesh, const Load *load)
{
  const Pressed p = pressed_by(mesh, load);
  const PetscReal height = p.high - p.low, depth = load->level - p.low;
  if (!(height > 0.) || (depth <= 3. * height && (depth < 0. || depth >= 0.02 * height))) return;
  Warn("loads.%s.level: %.6g m, but the faces of %s reach from %.6g to %.6g m: expected an "
       "elevation of the mesh",
       load->name, (double)load->level, load->target, (double)p.low, (double)p.high);
}

/* Returns the impedance rho c_s [kg/(m2 s)] of a group; 0: it is rigid or has no mass. */
static PetscReal impedance_of(const Material *m)
{
  return m->rigid || !(m->density > 0.) ? 0.
                                        : PetscSqrtReal(m->density * m->young / (2. * (1. + m->poisson)));
}

/* Returns whether the line from p along n passes through a convex block ahead of p. */
static PetscBool is_ahead(const BlockMesh *mesh, PetscInt block, const PetscReal p[2], const PetscReal n[2])
{
  PetscReal first = PETSC_INFINITY, last = PETSC_NINFINITY;
  for (PetscInt k = 0; k < BlockCorners(mesh->blocks + 4 * block); k++) {
    const PetscReal *a = corner_of(mesh, block, k), *b = corner_of(mesh, block, k + 1);
    const PetscReal da = n[0] * (a[1] - p[1]) - n[1] * (a[0] - p[0]),
                    db = n[0] * (b[1] - p[1]) - n[1] * (b[0] - p[0]);
    if ((da > 0.) == (db > 0.)) continue;
    const PetscReal t = da / (da - db), x = a[0] + t * (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]);
    const PetscReal way = n[0] * (x - p[0]) + n[1] * (y - p[1]);
    first = PetscMin(first, way), last = PetscMax(last, way);
  }
  return (PetscBool)(last > PetscMax(first, 0.));
}

/* Returns the group of the stiffest ground above a face, on the way of waves that go up from it. */
static PetscInt stiffest_above(const Scene *scene, const BlockMesh *mesh, const PetscInt face[2])
{
  const PetscReal *a = corner_of(mesh, face[0], face[1]), *b = corner_of(mesh, face[0], face[1] + 1);
  const PetscReal p[2] = {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])}, n[2] = {a[1] - b[1], b[0] - a[0]};
  PetscInt found = mesh->block_group[face[0]];
  for (PetscInt e = 0; e < mesh->n_blocks; e++)
    if (impedance_of(scene->materials + mesh->block_group[e]) > impedance_of(scene->materials + found) &&
        is_ahead(mesh, e, p, n))
      found = mesh->block_group[e];
  return found;
}

/* Warns of soft ground below a quiet base. Waves come out of it as out of ground that goes on below with the
   material of its faces. Where that is softer than the ground above, as one soft row at the end of a mesh,
   little of them enters it. A dam is stiffer than its rock, too, but stands on less than half of the base. */
static void doubt_half_space(const Scene *scene, const BlockMesh *mesh, const Support *s)
{
  enum { FACES = 16 };
  const PetscReal alike = 1.1;
  const FaceSet *set = s->boundary == BOUNDARY_QUIET && s->motion[0] ? set_of(mesh, s->target) : NULL;
  PetscInt checks = 0, softer = 0, soft = -1, stiff = -1;
  PetscReal most = alike;
  for (PetscInt i = 0; set && i < set->n; i += (set->n + FACES - 1) / FACES) {
    const PetscInt above = stiffest_above(scene, mesh, set->faces + 2 * i);
    PetscInt below = mesh->block_group[set->faces[2 * i]];
    for (PetscInt g = 0; g < mesh->n_groups; g++)
      if (!strcmp(mesh->group_names[g], s->half_space)) below = g;
    const PetscReal ratio = impedance_of(scene->materials + above) / impedance_of(scene->materials + below);
    checks++, softer += ratio > alike;
    if (ratio > most) most = ratio, soft = below, stiff = above;
  }
  if (2 * softer <= checks) return;
  const PetscReal Z = impedance_of(scene->materials + soft);
  Warn("supports.%s: waves come through it from ground of group %s (rho c_s %.4g kg/m2/s), "
       "which is softer than %s above it (%.4g): of a pulse %s gets %.3g of what it would get from ground "
       "like itself; expected half_space: the group that goes on below",
       s->name, mesh->group_names[soft], (double)Z, mesh->group_names[stiff], (double)(most * Z),
       mesh->group_names[stiff], (double)(2. / (1. + most)));
}

void WarnImplausible(const Scene *scene, const BlockMesh *mesh)
{
  static PetscInt warned; // once, because advise.c sets up the same mesh many times
  if (AlreadyWarned(&warned)) return;
  doubt_size(scene, mesh);
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++)
    doubt_half_space(scene, mesh, s);
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    const Load *load = scene->loads + l;
    if (load->kind == LOAD_RESERVOIR || load->kind == LOAD_OVERFLOW) doubt_level(mesh, load);
    if (load->kind == LOAD_UPLIFT || load->kind == LOAD_DRAIN) doubt_gallery(scene, load);
  }
  for (const Stage *stage = scene->stages; stage < scene->stages + scene->n_stages; stage++) {
    doubt_side(scene, stage);
    for (PetscInt i = 0; i < stage->n_loads; i++)
      if (stage->loads[i] >= 0 && comes_with_water(scene->loads + stage->loads[i]))
        doubt_water_beside(scene, mesh, stage->loads[i], stage);
    for (PetscInt i = 0; i < stage->n_loads; i++)
      if (stage->loads[i] >= 0 && follows_level(scene->loads + stage->loads[i]))
        doubt_lower_water(scene, mesh, stage->loads[i], stage);
    doubt_twice(scene, stage);
  }
}
