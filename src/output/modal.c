/* modal.c: writes small free vibrations: lines on the terminal, summary.json, shapes. */
#include "output/output.h"

enum { MOST_SHOWN = 12 }; /* largest number of modes on the terminal */

PetscErrorCode VibrationDestroy(Vibration *v)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(v->omega2, v->mass, v->factor, v->shape, v->error));
  PetscCall(PetscMemzero(v, sizeof(*v)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal VibrationHertz(const Vibration *v, PetscInt mode)
{
  return v->omega2[mode] < 0. ? NAN : PetscSqrtReal(v->omega2[mode]) / (2. * PETSC_PI);
}

PetscReal VibrationMass(const Vibration *v, PetscInt mode, int x)
{
  const PetscReal factor = v->factor[2 * mode + x];
  return factor * factor * v->mass[mode];
}

/* Returns the effective mass [-] of a mode, -1: of all, over the mass that can move; 0 where nothing can
   move. */
static PetscReal part_of(const Vibration *v, PetscInt mode, int x)
{
  PetscReal sum = 0.;
  for (PetscInt i = mode < 0 ? 0 : mode; i < (mode < 0 ? v->n : mode + 1); i++) sum += VibrationMass(v, i, x);
  return v->moving[x] > 0. ? sum / v->moving[x] : 0.;
}

/* ---- terminal */

/* Prints the state to which the modes belong, and the effects that they leave out. */
static void report_state(const Problem *p)
{
  const Vibration *v = &p->output->vibration;
  const Stage *before = StageBefore(p->scene, p->scene->stages + p->number);
  PetscBool lets_go = PETSC_FALSE;
  for (PetscInt i = 0; i < p->scene->n_supports; i++)
    lets_go = (PetscBool)(lets_go || p->scene->supports[i].boundary != BOUNDARY_FIXED);
  printf("  about %s%s: %" PetscInt_FMT " of %" PetscInt_FMT " contacts open in part or whole stay so",
         before ? "the end of stage " : "the undeformed state", before ? before->name : "", v->contacts[1],
         v->contacts[0]);
  if (v->contacts[2]) printf(", %" PetscInt_FMT " that slip stick", v->contacts[2]);
  printf("; water in joints is drained%s\n", lets_go ? "; boundaries that let waves out are held" : "");
}

void VibrationReport(const Problem *p)
{
  const Vibration *v = &p->output->vibration;
  if (p->m->rank) return;
  printf("  %4s %11s %11s %14s %14s%s\n", "mode", "f [Hz]", "period [s]", "mass x [%]", "mass y [%]",
         v->reduced ? "  too high by [%]" : "");
  for (PetscInt i = 0; i < PetscMin(v->n, MOST_SHOWN); i++) {
    const PetscReal f = VibrationHertz(v, i);
    char period[32] = "-";
    if (f > 0.) snprintf(period, sizeof(period), "%.5g", (double)(1. / f));
    printf("  %4d %11.5g %11s %14.2f %14.2f", (int)i + 1, (double)f, period, 100. * (double)part_of(v, i, 0),
           100. * (double)part_of(v, i, 1));
    if (v->reduced && PetscIsNanReal(v->error[i]))
      printf(" %16s", "not known");
    else if (v->reduced)
      printf(" %16.2g", 100. * (double)v->error[i]);
    printf("\n");
  }
  if (v->n > MOST_SHOWN) printf("  %4s and %d more in summary.json\n", "", (int)(v->n - MOST_SHOWN));
  printf("  %4s %11s %11s %14.2f %14.2f\n", "all", "", "", 100. * (double)part_of(v, -1, 0),
         100. * (double)part_of(v, -1, 1));
  report_state(p);
  fflush(stdout);
}

/* ---- files */

void SummaryVibration(FILE *f, const Vibration *v)
{
  fprintf(f, "      \"modes\": {");
  JsonNumber(f, "mass_x", v->moving[0], ", ");
  JsonNumber(f, "mass_y", v->moving[1], ", ");
  JsonNumber(f, "sum_x", part_of(v, -1, 0), ", ");
  JsonNumber(f, "sum_y", part_of(v, -1, 1), ", ");
  JsonCount(f, "missed", v->missed, ", ");
  JsonCount(f, "contacts", v->contacts[0], ", ");
  JsonCount(f, "open", v->contacts[1], ", ");
  JsonCount(f, "slipping", v->contacts[2], ", ");
  fprintf(f, "\"list\": [");
  for (PetscInt i = 0; i < v->n; i++) {
    const PetscReal hertz = VibrationHertz(v, i);
    fprintf(f, "%s\n        {", i ? "," : "");
    JsonNumber(f, "f", hertz, ", ");
    JsonNumber(f, "period", hertz > 0. ? 1. / hertz : NAN, ", ");
    JsonNumber(f, "omega2", v->omega2[i], ", ");
    JsonNumber(f, "modal_mass", v->mass[i], ", ");
    JsonNumber(f, "factor_x", v->factor[2 * i], ", ");
    JsonNumber(f, "factor_y", v->factor[2 * i + 1], ", ");
    JsonNumber(f, "mass_x", VibrationMass(v, i, 0), ", ");
    JsonNumber(f, "mass_y", VibrationMass(v, i, 1), v->reduced ? ", " : "}");
    if (v->reduced) JsonNumber(f, "too_high", v->error[i], "}");
  }
  fprintf(f, "]},\n");
}

PetscErrorCode GatherVibration(const Model *m, const Vibration *v, StageFields *fields)
{
  const PetscInt width = 2 * v->n;
  PetscInt *place;
  PetscReal *rows;
  PetscFunctionBeginUser;
  fields->n_modes = v->n;
  if (!v->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(PetscMax(1, m->n_owned), &place));
  PetscCall(PetscMalloc1(PetscMax(1, width * m->n_owned), &rows));
  PetscCall(PetscArraycpy(place, m->vertex_file, m->n_owned));
  PetscCall(PetscArraycpy(rows, v->shape, width * m->n_owned));
  PetscCall(GatherPlaced(m->comm, m->n_owned, place, width, rows, m->n_vertices_global, &fields->modes));
  PetscFunctionReturn(PETSC_SUCCESS);
}
