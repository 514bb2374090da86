/* wave.c: applies the pressure that a wave adds to still water, while its crest stands at the wall. */
#include "water/water.h"
#include "scene/reader.h"

enum { PLACES = 3 };
static const PetscReal ROUNDING = 1e-9; /* relative to the height of the diagram */

/* Pressure along the height, linear between these places from top to bottom; zero outside. */
typedef struct {
  PetscReal y[PLACES], p[PLACES], thickness; /* [m], [Pa], [m] */
} Diagram;

/* Returns Molitor's diagram: 2.4 rho g h at h/8 above the still water, zero at 4 h/3 above and h/3 below
   it. Its resultant is 2 rho g h^2 at 3 h/8 above the still water. */
static Diagram molitor(const Load *load, PetscReal rho_g)
{
  const PetscReal h = load->surface.height, y = load->level;
  return (Diagram){{y + 4. * h / 3., y + h / 8., y - h / 3.}, {0., 2.4 * rho_g * h, 0.}, 0.};
}

/* Returns Sainflou's diagram of a wave that an upright wall reflects. The middle of its height is h0 above
   the still water. */
static Diagram sainflou(const Load *load, PetscReal rho_g)
{
  const PetscReal h = load->surface.height, length = load->surface.length, y = load->level,
                  depth = y - load->surface.bottom, kd = 2. * PETSC_PI * depth / length,
                  h0 = PETSC_PI * h * h / length / PetscTanhReal(kd), below = rho_g * h / cosh(kd);
  const PetscReal still = (below + rho_g * depth) * (h + h0) / (depth + h + h0);
  return (Diagram){{y + h + h0, y, y - depth}, {0., still, below}, 0.};
}

static Diagram diagram_of(const Load *load, PetscReal rho_g)
{
  return load->surface.formula == WAVE_MOLITOR ? molitor(load, rho_g) : sainflou(load, rho_g);
}

/* Applies the pressure to the part of a face between two places. */
static void press_between(const PetscReal x[4], const PetscReal y[2], const PetscReal p[2],
                          PetscReal thickness, PetscReal f[4])
{
  const PetscReal rise = x[3] - x[1];
  PetscReal t[2] = {0., 1.}, at[2];
  if (rise == 0. && !(x[1] <= y[0] && x[1] > y[1])) return;
  for (int k = 0; k < 2 && rise != 0.; k++)
    t[k] = PetscClipInterval((y[rise > 0. ? 1 - k : k] - x[1]) / rise, 0., 1.);
  for (int k = 0; k < 2; k++) at[k] = p[1] + (x[1] + t[k] * rise - y[1]) / (y[0] - y[1]) * (p[0] - p[1]);
  if (t[1] > t[0]) PushAlongFace(t, at, x, thickness, f);
}

static void press(const PetscReal x[4], const void *context, PetscReal f[4])
{
  const Diagram *d = context;
  for (int i = 0; i < 4; i++) f[i] = 0.;
  for (int i = 0; i < PLACES - 1; i++) press_between(x, d->y + i, d->p + i, d->thickness, f);
}

static PetscErrorCode applied(const TermView *v, PetscInt row, PetscReal *f_vertex)
{
  const Load *load = v->scene->loads + row;
  Diagram d = diagram_of(load, load->density * v->scene->gravity);
  PetscFunctionBeginUser;
  d.thickness = v->m->materials.thickness;
  PressOnFaces(v, load->target, press, &d, f_vertex);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of a wave whose pressure extends beyond its faces. */
static void warn(const Load *load, const PetscReal ends[2])
{
  const Diagram d = diagram_of(load, 1.);
  const PetscReal reaches[2] = {d.y[PLACES - 1], d.y[0]};
  static const char *const ways[2] = {"down", "up"}, *const sides[2] = {"below", "above"};
  const PetscReal slack = ROUNDING * (reaches[1] - reaches[0]);
  if (ends[0] > ends[1]) return; // no faces
  for (int k = 0; k < 2; k++) {
    if (k ? reaches[k] <= ends[k] + slack : reaches[k] >= ends[k] - slack) continue;
    Warn("loads.%s: its pressure reaches %s to %.4g m, the faces of %s to %.4g m: what is "
         "%s them is left out",
         load->name, ways[k], (double)reaches[k], load->target, (double)ends[k], sides[k]);
  }
}

/* Collective. Warns of waves beyond their faces. */
static PetscErrorCode create(const TermView *v, void **memory)
{
  static PetscInt runs; // only once, because advise.c sets up the same mesh many times
  const PetscBool warned = AlreadyWarned(&runs);
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  *memory = NULL;
  PetscCallMPI(MPI_Comm_rank(v->m->comm, &rank));
  for (PetscInt l = 0; l < v->scene->n_loads; l++) {
    const Load *load = v->scene->loads + l;
    PetscReal ends[2];
    if (load->kind != LOAD_WAVE) continue;
    PetscCall(FacesEnd(v->m, load->target, ends));
    if (!rank && !warned) warn(load, ends);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- keys */

/* Returns the wave height [m] on inland water for a wind [m/s] and a fetch [m]: Stevenson's formula with
   Molitor's factor for the wind (1935), which takes km/h and km. */
static PetscReal height_by_wind(PetscReal wind, PetscReal fetch)
{
  const PetscReal km = fetch / 1000.;
  const PetscReal more = km < 32. ? 0.763 - 0.271 * pow(km, 0.25) : 0.;
  return 0.032 * sqrt(3.6 * wind * km) + more;
}

/* Checks the keys of a wave by Sainflou, whose formula is for waves that do not break. A wave breaks when
   it is too high for its length or depth (Miche 1944). */
static PetscErrorCode complete_sainflou(Reader *r, const char *path, const Load *load)
{
  const SurfaceKeys *wave = &load->surface;
  const PetscBool sainflou = (PetscBool)(wave->formula == WAVE_SAINFLOU);
  PetscBool given = PETSC_FALSE, other = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "length", &given));
  if (given && !sainflou) COMPLAIN(r, "it is for formula: sainflou");
  if (sainflou && !given) COMPLAIN_MISSING(r, "missing [m]: sainflou needs the length of the wave");
  PetscCall(IsGiven(r, path, "bottom", &other));
  if (other && !sainflou) COMPLAIN(r, "it is for formula: sainflou");
  if (sainflou && !other) COMPLAIN_MISSING(r, "missing [m]: sainflou needs the ground below the water");
  if (!sainflou || !given || !other) PetscFunctionReturn(PETSC_SUCCESS);
  if (wave->bottom >= load->level)
    COMPLAIN(r, "%g is not below the level %g [m]", (double)wave->bottom, (double)load->level);
  const PetscReal most = 0.142 * wave->length *
                         tanh(2. * PETSC_PI * (load->level - wave->bottom) / wave->length);
  PetscCall(IsGiven(r, path, "height", &given));
  if (wave->height > most)
    COMPLAIN(r, "a wave of %.4g m breaks: of this length it is %.4g m high at most in %.4g m of water",
             (double)wave->height, (double)most, (double)(load->level - wave->bottom));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteWave(Reader *r, const char *path, Load *load)
{
  SurfaceKeys *wave = &load->surface;
  PetscBool wind = PETSC_FALSE, fetch = PETSC_FALSE, height = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "wind", &wind));
  PetscCall(IsGiven(r, path, "fetch", &fetch));
  if (wind != fetch) COMPLAIN_MISSING(r, "missing: wind and fetch belong together");
  PetscCall(IsGiven(r, path, "height", &height));
  if (height == (PetscBool)(wind && fetch))
    COMPLAIN_MISSING(r, "a wave needs its height [m], or wind [m/s] and fetch [m], one of them");
  if (wind && fetch && !height) wave->height = height_by_wind(wave->wind, wave->fetch);
  PetscCall(complete_sainflou(r, path, load));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Wave_term = {
    .name = "wave", .loads = 1u << LOAD_WAVE, .presses = PETSC_TRUE, .create = create, .applied = applied};
