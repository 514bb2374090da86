/* history_rows.c: writes the rows of history.csv, joint_history.csv and anchor_history.csv. Rank 0 only. */
#include "output/output.h"
#include <math.h>

/* ---- history.csv */

/* Writes the energies of a row; nan in a static stage, which has no energy account. */
static void history_energies(FILE *f, const Problem *p)
{
  const Energies *e = &p->result->energy;
  const PetscReal value[] = {e->strain,  e->joints,   e->outside,  e->supports,  e->friction,
                             e->damping, e->incoming, e->radiated, e->detection, e->balance};
  fprintf(f, ",%.10g", p->state->time);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(value); i++)
    fprintf(f, ",%.10g", StageInTime(p->stage) ? value[i] : NAN);
}

void HistoryHeader(FILE *f, const Scene *scene, const Model *model, const Result *found)
{
  fprintf(f, "cycle,stage,ramp,ratio,kinetic_J,alpha_per_s,dt_s,alpha_dt,u_max_m");
  if (SceneInTime(scene))
    fprintf(f, ",time_s,strain_J,joints_J,outside_J,supports_J,friction_J,damping_J,incoming_J,radiated_J,"
               "detection_J,balance_J");
  for (PetscInt p = 0; p < model->mesh.n_points; p++) {
    fprintf(f, ",%s_ux_m,%s_uy_m", model->mesh.point_names[p], model->mesh.point_names[p]);
  }
  for (PetscInt p = 0; p < model->mesh.n_points && found->ground_moves; p++)
    fprintf(f, ",%s_rx_m,%s_ry_m", model->mesh.point_names[p], model->mesh.point_names[p]);
  for (PetscInt i = 0; i < scene->n_supports && SceneInTime(scene); i++)
    fprintf(f, ",%s_fx_N,%s_fy_N", scene->supports[i].name, scene->supports[i].name);
  if (ScenePushes(scene)) fprintf(f, ",push_m,push_N");
  fprintf(f, "\n");
}

/* Writes the displacements of points relative to the ground, where there is one ground that moves. */
static void history_over_ground(FILE *f, const Problem *p)
{
  const Result *r = p->found;
  PetscReal ground[2];
  if (!r->ground_moves) return;
  GroundPlace(&r->ground, p->state->time, ground);
  for (PetscInt i = 0; i < p->m->mesh.n_points; i++)
    fprintf(f, ",%.10g,%.10g", r->probes[i].u[0] - ground[0], r->probes[i].u[1] - ground[1]);
}

/* Writes the forces of supports; nan in a static stage, where they are not summed. */
static void history_supports(FILE *f, const Problem *p)
{
  const PetscReal *force = p->found->histories.support;
  for (PetscInt i = 0; i < 2 * p->scene->n_supports && SceneInTime(p->scene); i++)
    fprintf(f, ",%.10g", force ? force[i] : NAN);
}

void HistoryRow(const Problem *p, PetscReal u_max)
{
  FILE *f = p->output->files[HISTORY].file;
  const Probe *probes = p->found->probes;
  const State *s = p->state;
  fprintf(f, "%lld,%s,%.10g,%.10g,%.10g,%.10g,%.10g,%.10g,%.10g", (long long)s->cycle, p->stage->name,
          s->applied.ramp, p->result->ratio, p->result->kinetic, s->alpha, s->dt, s->alpha * s->dt, u_max);
  if (SceneInTime(p->scene)) history_energies(f, p);
  for (PetscInt i = 0; i < p->m->mesh.n_points; i++)
    fprintf(f, ",%.10g,%.10g", probes[i].u[0], probes[i].u[1]);
  history_over_ground(f, p);
  history_supports(f, p);
  if (ScenePushes(p->scene)) {
    const Push *push = PushOf(s);
    const PetscBool pushed = (PetscBool)(p->stage->kind == STAGE_PUSHOVER && s->applied.ramp >= 1.);
    fprintf(f, ",%.10g,%.10g", pushed ? push->aim : NAN, pushed ? push->force : NAN);
  }
  fprintf(f, "\n");
  fflush(f);
}

/* ---- joint_history.csv */

void JointHistoryHeader(FILE *f)
{
  fprintf(f, "time_s,stage,joint,N_N,T_N,factor_peak,factor_residual,slip_m,slip_largest_m,opening_m,"
             "open_length_m,length_m\n");
}

void JointHistoryRows(const Problem *p)
{
  Histories *h = &p->found->histories;
  FILE *f = p->output->files[JOINT_HISTORY].file;
  if (!f || !h->joint || PetscIsNanReal(h->joint_time)) return;
  for (PetscInt j = 0; j < h->n_joints; j++) {
    const PetscReal *row = h->joint + CHECK_COLUMNS * j;
    if (PetscIsNanReal(row[CHECK_LENGTH])) continue;
    fprintf(f, "%.10g,%s,%s", h->joint_time, p->stage->name, p->scene->joints[j].name);
    for (int k = 0; k < CHECK_COLUMNS; k++)
      fprintf(f, ",%.10g", PetscIsNanReal(row[k]) ? NAN : row[k]); // a NaN may have a sign
    fprintf(f, "\n");
  }
  fflush(f);
  h->joint_time = NAN;
}

/* ---- anchor_history.csv: a term has the columns, and a row for each named object */

void TermHistoryHeader(FILE *f)
{
  fprintf(f, "time_s,stage,anchor,force_N,largest_so_far_N,elongation_m,plastic_m,lost_J\n");
}

void TermHistoryRows(const Problem *p)
{
  Histories *h = &p->found->histories;
  const AnchorRecord *record = &h->things;
  FILE *f = p->output->files[TERM_HISTORY].file;
  if (!f || PetscIsNanReal(h->things_time)) return;
  for (PetscInt i = 0; i < record->n_rows; i++) {
    const PetscReal *row = record->values + i * record->n_columns;
    if (PetscIsNanReal(row[0])) continue;
    fprintf(f, "%.10g,%s,%s", h->things_time, p->stage->name, record->names[i]);
    for (PetscInt c = 0; c < record->n_columns; c++) fprintf(f, ",%.10g", row[c]);
    fprintf(f, "\n");
  }
  fflush(f);
  h->things_time = NAN;
}
