/* warnings.c: warns of features of a scene that are allowed but rarely wanted. Rank 0, once a run. */
#include "run/run.h"

/* Warns of slender blocks, which set the time step and are stiff in bending. */
void WarnSlender(const BlockMesh *mesh)
{
  static PetscInt warned; // once, because advise.c sets up the same mesh many times
  static PetscInt n, worst;
  static PetscReal ratio;
  if (mesh) MeshSlender(mesh, &n, &worst, &ratio);
  if (!n || AlreadyWarned(&warned)) return;
  Warn("%" PetscInt_FMT " block%s with an aspect ratio above 1000; worst is block %" PetscInt_FMT
       ", %.3g: expect many cycles and stresses of little worth there",
       n, Plural(n), worst, (double)ratio);
}

/* Poisson's ratio from which full blocks lock. A cantilever of 20 by 4 of them is 10 % too stiff in bending
   at 0.2, 19 % at 0.45, 49 % at 0.49 (bending blocks: 0, 2 and 3 %). In plane stress blocks never lock. */
static const PetscReal LOCKS_FROM = 0.45;

void WarnLocking(const Scene *scene)
{
  static PetscInt warned;
  if (scene->plane != PLANE_STRAIN || AlreadyWarned(&warned)) return;
  for (PetscInt g = 0; g < scene->n_materials; g++) {
    const Material *material = scene->materials + g;
    if (material->rigid || material->element != ELEMENT_FULL || material->poisson < LOCKS_FROM) continue;
    Warn("materials.%s: at Poisson's ratio %.4g blocks of element: full are much too stiff "
         "in bending: take element: bending, and blocks of 4 vertices",
         material->name, (double)material->poisson);
  }
}

/* Warns of stages that Newton's method does not serve: it keeps its contacts, so stages of variable
   connectivity take explicit cycles. */
void WarnExplicit(const Scene *scene)
{
  static PetscInt warned;
  char names[NAMES_LENGTH] = "";
  if (scene->method != METHOD_PRECONDITIONED || AlreadyWarned(&warned)) return;
  for (PetscInt s = 0; s < scene->n_stages; s++) {
    const Stage *stage = scene->stages + s;
    if (!StageRelaxes(stage) || stage->connectivity != CONNECTIVITY_VARIABLE) continue;
    AddName(stage->name, names);
  }
  if (names[0]) Warn("preconditioned needs fixed connectivity; by explicit cycles:%s", names);
}

/* Warns of strengths in an elastic joint, where they limit nothing. A row of joints without a law takes the
   law of the default row. */
void WarnElastic(const Scene *scene)
{
  static PetscInt warned;
  if (AlreadyWarned(&warned)) return;
  for (PetscInt j = 1; j < scene->n_joints; j++) {
    const Joint *joint = scene->joints + j, *other = scene->joints;
    PetscBool elastic = (PetscBool)(joint->defined && joint->law == LAW_ELASTIC);
    for (PetscInt s = 0; s < scene->n_stages && elastic; s++)
      elastic = (PetscBool)(scene->stages[s].joints[j].law == LAW_ELASTIC);
    const PetscReal strength[3] = {joint->friction[0], joint->cohesion[0], joint->tension[0]},
                    inherited[3] = {other->friction[0], other->cohesion[0], other->tension[0]};
    static const char *const names[3] = {"friction", "cohesion", "tension"};
    for (int k = 0; k < 3 && elastic; k++) {
      if (!(strength[k] > 0.) || strength[k] == inherited[k] || isinf(strength[k])) continue;
      Warn("joints.%s: its law is elastic in every stage, so %s %g limits nothing: give it "
           "law: mohr_coulomb",
           joint->name, names[k], (double)strength[k]);
      break;
    }
  }
}

/* Warns of a joint without shear stiffness: it carries no shear, so it never reaches its strength. */
void WarnShear(const Scene *scene)
{
  static PetscInt warned;
  if (AlreadyWarned(&warned)) return;
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    const Joint *joint = scene->joints + j;
    if (!joint->defined || joint->k_s > 0. || joint->law == LAW_ELASTIC) continue;
    if (!(joint->friction[0] > 0. || joint->cohesion[0] > 0.)) continue;
    Warn("joints.%s: k_s 0 bears no shear, so friction %g and cohesion %g Pa hold nothing: "
         "expected k_s > 0, or friction 0 and cohesion 0 for a smooth joint",
         joint->name, (double)joint->friction[0], (double)joint->cohesion[0]);
  }
}

/* Warns of a tension beyond the apex of the shear strength. which: "_residual" or "" */
static void warn_apex(const Joint *joint, int k, const char *which, const char *why)
{
  Warn("joints.%s: tension%s, %.4g Pa, is beyond the apex of the shear strength, "
       "cohesion%s / tan(friction%s) = %.4g Pa: %s",
       joint->name, which, (double)joint->tension[k], which, which, (double)JointApex(joint, k), why);
}

/* Warns of tensile strength beyond the apex of the shear strength: a joint that pulls so hard carries no
   shear there. A brittle joint fails there, so it never has the tension that it was given. A joint that keeps
   its tension pulls on, and elsewhere carries more than its resultant would. */
void WarnApex(const Scene *scene)
{
  static PetscInt warned;
  if (AlreadyWarned(&warned)) return;
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    PetscBool warned[2] = {PETSC_FALSE, PETSC_FALSE};
    for (PetscInt s = 0; s < scene->n_stages; s++)
      for (int k = 0; k < 2; k++) {
        const Joint *joint = scene->stages[s].joints + j;
        if (!joint->defined || joint->law == LAW_ELASTIC ||
            joint->tension[k] <= JointApex(joint, k) * (1. + 1e-9))
          continue;
        if (warned[k]) continue;
        warned[k] = PETSC_TRUE;
        warn_apex(
            joint, k, k ? "_residual" : "",
            k ? "a place that pulls by more bears no shear and the others all of theirs, so it can stand "
                "with a sliding factor below 1"
              : "a place that pulls by more fails in shear, so the joint never has this tension");
      }
  }
}

/* Warns of blocks that are held across the plane, where cold alone cracks them. */
static void warn_across(const Scene *scene, const Material *m)
{
  PetscBool any = PETSC_FALSE;
  if (m->law != MATERIAL_DAMAGE || !(m->expansion > 0.) || m->free_across) return;
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    const Load *load = scene->loads + l;
    any = (PetscBool)(any || (load->kind == LOAD_TEMPERATURE &&
                              (!load->n_groups || NameRow(load->n_groups, load->groups, m->name) >= 0)));
  }
  if (!any) return;
  Warn("materials.%s: held across the plane, its blocks crack there when they are %.3g K "
       "colder, whatever holds them within it; between contraction joints they are free: free_across: true",
       m->name, (double)(m->tension / (m->young * m->expansion)));
}

void WarnLaws(const Scene *scene)
{
  static PetscInt warned;
  if (AlreadyWarned(&warned)) return;
  for (PetscInt g = 0; g < scene->n_materials; g++) warn_across(scene, scene->materials + g);
  for (PetscInt s = 0; s < scene->n_stages; s++)
    for (PetscInt g = 0; g < scene->n_materials; g++) {
      const Stage *stage = scene->stages + s;
      const Material *material = scene->materials + g;
      if (material->law == MATERIAL_ELASTIC) continue;
      if (stage->kind == STAGE_MODES)
        Warn("stages.%s: its modes take blocks of group %s as elastic and whole", stage->name,
             material->name);
      if (stage->kind == STAGE_STRENGTH_REDUCTION || StageHasDesignStrengths(stage))
        Warn("stages.%s: it weakens joints; blocks of group %s keep the strengths of their "
             "law",
             stage->name, material->name);
    }
}

/* ---- numbers that are likely to be in another unit */

/* Warns if a value is outside its plausible range. Zero and unset values are skipped. section: NULL for a key
   of the top level, which has no name either. */
static void doubt(const char *section, const char *name, const char *key, PetscReal x, PetscReal low,
                  PetscReal high, const char *unit, const char *why)
{
  if (!(x > 0.) || x >= PETSC_INFINITY || (x >= low && x <= high)) return;
  const char *dot = section ? "." : "";
  Warn("%s%s%s%s%s: %.6g %s is not within %g to %g: %s", section ? section : "", dot, section ? name : "",
       dot, key, (double)x, unit, (double)low, (double)high, why);
}

static void doubt_material(const Material *m)
{
  const char *const of = "materials", *const stress = "1 MPa is 1e6 Pa, and such a value may carry its unit";
  doubt(of, m->name, "density", m->density, 100., 20000., "kg/m3", "24 kN/m3 would be 2400 kg/m3");
  if (m->rigid) return;
  doubt(of, m->name, "young", m->young, 1e7, 1e12, "Pa",
        "stone and concrete have 1 to 100 GPa, 1e9 to 1e11 Pa");
  doubt(of, m->name, "tension", m->tension, 1e3, 1e8, "Pa", stress);
  doubt(of, m->name, "compression", m->compression, 1e4, 1e9, "Pa", stress);
  doubt(of, m->name, "cohesion", m->cohesion, 5e3, 1e8, "Pa", stress);
  doubt(of, m->name, "friction", m->friction, 2., 80., "degree", "it is an angle, not its tangent");
  doubt(of, m->name, "expansion", m->expansion, 1e-7, 1e-4, "1/K", "stone and concrete have 5e-6 to 1.2e-5");
}

/* Warns of doubtful numbers of a joint. before: the row that a stage changes, whose numbers are not checked
   again; NULL: this is a row of the scene. */
static void doubt_joint(const char *of, const Joint *j, const Joint *before)
{
  static const Joint none;
  const Joint *b = before ? before : &none; // what is 0 is left alone, and what is as before is 0 here
  const char *const stress = "1 MPa is 1e6 Pa, and such a value may carry its unit";
  const PetscReal k_n = j->k_n == b->k_n ? 0. : j->k_n,
                  friction = j->friction[0] == b->friction[0] ? 0. : j->friction[0],
                  cohesion = j->cohesion[0] == b->cohesion[0] ? 0. : j->cohesion[0],
                  tension = j->tension[0] == b->tension[0] ? 0. : j->tension[0],
                  compression = j->compression == b->compression ? 0. : j->compression;
  char closes[96];
  snprintf(closes, sizeof closes, "it closes by %.3g m under 1 MPa", 1e6 / (double)j->k_n);
  doubt(of, j->name, "k_n", k_n, 1e7, 1e14, "Pa/m", closes);
  doubt(of, j->name, "friction", friction, 2., 80., "degree", "it is an angle, not its tangent");
  doubt(of, j->name, "cohesion", cohesion, 5e3, 1e8, "Pa", stress);
  doubt(of, j->name, "tension", tension, 1e3, 1e8, "Pa", stress);
  doubt(of, j->name, "compression", compression, 1e4, 1e10, "Pa", stress);
}

/* Warns of joints as stages change them. */
static void doubt_stages(const Scene *scene)
{
  char of[NAME_LENGTH + 16];
  for (PetscInt s = 0; s < scene->n_stages; s++) {
    const PetscInt base = StageBase(scene, s);
    const Joint *before = base < 0 ? scene->joints : scene->stages[base].joints;
    snprintf(of, sizeof of, "stages.%s.joints", scene->stages[s].name);
    for (PetscInt j = 0; j < scene->n_joints; j++)
      if (scene->joints[j].defined) doubt_joint(of, scene->stages[s].joints + j, before + j);
  }
}

/* Returns whether a load factor multiplies the load, or a pushover: then its value is a unit. */
static PetscBool is_raised(const Scene *scene, const Load *load)
{
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++)
    for (PetscInt i = 0; i < s->n_rises && (s->kind == STAGE_LOAD_FACTOR || s->kind == STAGE_PUSHOVER); i++)
      if (s->rises[i] == load - scene->loads) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Warns of a force or pressure that is out of range, by its largest value in time. */
static void doubt_force(const Scene *scene, const Load *load)
{
  const PetscBool presses = (PetscBool)(load->kind == LOAD_PRESSURE),
                  pulls = (PetscBool)(load->kind == LOAD_TRACTION),
                  at_a_line = (PetscBool)(load->kind == LOAD_POINT_FORCE || load->kind == LOAD_CREST_LOAD);
  PetscReal factor = load->history[0] ? 0. : 1.;
  if (!(presses || pulls || at_a_line) || is_raised(scene, load)) return;
  for (PetscInt i = 0; i < load->n_levels && load->history[0]; i++)
    factor = PetscMax(factor, PetscAbsReal(load->levels_at[i]));
  const PetscReal size = factor * (presses ? PetscAbsReal(load->traction[0])
                                           : PetscHypotReal(load->traction[0], load->traction[1]));
  if (at_a_line)
    doubt("loads", load->name, "value", size, 1e2, 1e9, "N/m",
          "1 kN/m is 1e3 N/m, and such a value may carry its unit");
  else
    doubt("loads", load->name, presses ? "pressure" : "value", size, 1e3, 1e8, "Pa",
          "1 kPa is 1e3 Pa, and such a value may carry its unit");
}

static void doubt_load(const Scene *scene, const Load *load)
{
  const char *const of = "loads";
  doubt_force(scene, load);
  if (load->kind == LOAD_ICE)
    doubt(of, load->name, "force", load->traction[0], 1e3, 1e7, "N/m",
          "ice pushes with some 1e4 to 5e5 N/m, 10 to 500 kN/m");
  if (load->kind == LOAD_PSEUDO_STATIC)
    for (int x = 0; x < 2; x++)
      if (PetscAbsReal(load->coefficient[x]) > 1.)
        Warn("loads.%s.coefficient: %s %.6g is more than the weight: it is a part of it, "
             "12 %% is "
             "0.12",
             load->name, x ? "k_v" : "k_h", (double)load->coefficient[x]);
  if (load->kind == LOAD_UPLIFT && (load->uplift.rule == UPLIFT_USACE || load->uplift.rule == UPLIFT_FERC) &&
      load->uplift.efficiency > 0.67)
    Warn("loads.%s.efficiency: %.6g is more than drains are granted: USACE is quoted for 0.25 "
         "to 0.5, and 0.67 where it is verified",
         load->name, (double)load->uplift.efficiency);
  if (load->kind == LOAD_SILT)
    doubt(of, load->name, "density", load->density, 200., 1500., "kg/m3",
          "it is what silt weighs in water: of 19 kN/m3 with its water 9.2 kN/m3 are left");
  else
    doubt(of, load->name, "density", load->density, 500., 3000., "kg/m3", "9.81 kN/m3 would be 1000 kg/m3");
}

/* Warns of unusual numbers of an anchor. Strands of 1860 MPa are the strongest steel that anchors have;
   fibres are less stiff and no stronger. */
static void doubt_anchor(const Anchor *a)
{
  const char *const of = "anchors";
  char stress[96];
  doubt(of, a->entry.name, "area", a->area, 1e-6, 0.1, "m2", "1000 mm2 is 1e-3 m2");
  doubt(of, a->entry.name, "young", a->young, 1e9, 1e12, "Pa", "steel has 200 GPa, 2e11 Pa");
  for (PetscInt i = 0; i < a->n_forces; i++) {
    snprintf(stress, sizeof stress, "it is %.4g MPa in its area; steel bears up to 2000 MPa",
             (double)(a->prestress[i] / a->area / 1e6));
    doubt(of, a->entry.name, "prestress", a->prestress[i], 2e6 * a->area, 2.5e9 * a->area, "N", stress);
  }
}

/* Returns whether a stage lists the load. */
static PetscBool is_listed(const Scene *scene, PetscInt load)
{
  if (is_raised(scene, scene->loads + load)) return PETSC_TRUE;
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++)
    for (PetscInt i = 0; i < s->n_loads; i++)
      if (s->loads[i] == load) return PETSC_TRUE;
  return PETSC_FALSE;
}

void WarnDoubtful(const Scene *scene)
{
  static PetscInt warned;
  PetscInt n_anchors;
  char names[NAMES_LENGTH] = "";
  if (AlreadyWarned(&warned)) return;
  doubt(NULL, NULL, "gravity", scene->gravity, 9., 11., "m/s2", "981 cm/s2 and 32.2 ft/s2 are 9.81 m/s2");
  doubt(NULL, NULL, "thickness", scene->thickness, 0.01, 200., "m",
        "it is that of the slice, 1 m of a dam unless given");
  const Anchor *anchors = SceneEntries(scene, "anchors", &n_anchors);
  for (PetscInt a = 0; a < n_anchors; a++) doubt_anchor(anchors + a);
  for (PetscInt g = 0; g < scene->n_materials; g++) doubt_material(scene->materials + g);
  for (PetscInt j = 0; j < scene->n_joints; j++)
    if (scene->joints[j].defined) doubt_joint("joints", scene->joints + j, NULL);
  doubt_stages(scene);
  for (PetscInt l = 0; l < scene->n_loads; l++) doubt_load(scene, scene->loads + l);
  for (PetscInt l = 0; l < scene->n_loads; l++)
    if (!is_listed(scene, l)) AddName(scene->loads[l].name, names);
  if (names[0]) Warn("no stage lists:%s", names);
}

void WarnAgain(const Scene *scene)
{
  WarnSlender(NULL), WarnLocking(scene), WarnExplicit(scene), WarnElastic(scene), WarnShear(scene);
  WarnApex(scene), WarnLaws(scene), WarnDoubtful(scene);
}
