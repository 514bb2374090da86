/* ground_motions.c: writes records that a scene scales or corrects to files of their own, so that the motion
   that shook the model can be read and used again. */
#include "output/output.h"

static void write_record(FILE *f, const GroundMotion *m)
{
  const Record *r = &m->record;
  const char *unit = m->quantity == MOTION_VELOCITY ? "m/s" : "m/s2";
  fprintf(f, "# %s: %s, scaled or with its baseline corrected\n", m->entry.name, m->file);
  if (r->width == 2)
    fprintf(f, "# t [s], x [%s], y\n", unit);
  else
    fprintf(f, "# t [s], %s along %s\n", unit, m->direction == MOTION_ALONG_X ? "x" : "y");
  for (PetscInt i = 0; i < r->n; i++) {
    fprintf(f, "%.17g", (double)r->t[i]);
    for (PetscInt k = 0; k < r->width; k++) fprintf(f, ", %.17g", (double)r->x[r->width * i + k]);
    fprintf(f, "\n");
  }
}

void MotionsWrite(const Scene *scene, const char *folder, char message[MESSAGE_LENGTH])
{
  char name[NAME_LENGTH + 16];
  for (const GroundMotion *m = scene->motions; m < scene->motions + scene->n_motions; m++) {
    if (!MotionIsChanged(m) || message[0]) continue;
    snprintf(name, sizeof(name), "motion_%s.csv", m->entry.name);
    FILE *f = PartOpen(folder, name, message);
    if (!f) return;
    write_record(f, m);
    PartFinish(f, folder, name, message);
  }
}
