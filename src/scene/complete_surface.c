/* complete_surface.c: completes the keys of moving water at a dam: overflow, tailwater and waves. */
#include "scene/scene.h"
#include "scene/reader.h"
#include <math.h>
#include <string.h>

static PetscErrorCode complete_overflow(Reader *r, const char *path, const Load *load)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "crest", &given));
  if (!strcmp(load->surface.crest, load->target))
    COMPLAIN(r, "the face set %s is the upstream face, which has its own pressure: expected another face set",
             load->target);
  PetscCall(IsGiven(r, path, "crest_pressure", &given));
  if (load->surface.crest[0] && !given)
    COMPLAIN_MISSING(r, "missing [-]: the fraction of the static water pressure that acts on the crest");
  if (!load->surface.crest[0] && given) COMPLAIN(r, "there is no crest: give loads.%s.crest", load->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode complete_tailwater(Reader *r, const char *path, const Load *load)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "bottom", &given));
  if (load->surface.effective < 1. && !given)
    COMPLAIN_MISSING(r, "missing [m]: effective is a fraction of the depth above the ground");
  if (given && load->surface.bottom >= load->level)
    COMPLAIN(r, "%g is not below the level %g [m]", (double)load->surface.bottom, (double)load->level);
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

static PetscErrorCode complete_wave(Reader *r, const char *path, Load *load)
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

PetscErrorCode CompleteSurface(Reader *r, const char *path, Load *load)
{
  PetscFunctionBeginUser;
  if (load->kind == LOAD_OVERFLOW) PetscCall(complete_overflow(r, path, load));
  if (load->kind == LOAD_TAILWATER) PetscCall(complete_tailwater(r, path, load));
  if (load->kind == LOAD_WAVE) PetscCall(complete_wave(r, path, load));
  PetscFunctionReturn(PETSC_SUCCESS);
}
