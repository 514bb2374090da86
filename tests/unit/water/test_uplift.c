/* Uplift: the water pressure along a joint and on its faces, against closed forms. */
#include "water/uplift.h"
#include "check.h"

/* Forces of a bent diagram on a face that has the bend: resultant and moment are those of the integral. */
static void PressureOnFace(void)
{
  const UpliftDiagram d = {.n = 3, .s = {0., 4., 10.}, .p = {90., 30., 0.}};
  const PetscReal s[2] = {3., 7.}, x[4] = {3., 0., 7., 0.};
  PetscReal f[4];
  UpliftOnFace(&d, s, x, 2., f); // x runs to the right: the block is above, the water lifts it
  // from the start of the face: 45 to 30 Pa over 1 m, then 30 to 15 Pa over 3 m
  const PetscReal area = 37.5 + 67.5, moment = (45. + 2. * 30.) / 6. + 67.5 * 1. + 9. * (30. + 2. * 15.) / 6.;
  ENSURE_NEAR(f[0], 0., 1e-12);
  ENSURE_NEAR(f[1] + f[3], 2. * area, 1e-12);
  ENSURE_NEAR(4. * f[3], 2. * moment, 1e-11);
  // the same face run backwards, as that of the block below
  const PetscReal back_s[2] = {7., 3.}, back_x[4] = {7., 0., 3., 0.};
  PetscReal g[4];
  UpliftOnFace(&d, back_s, back_x, 2., g);
  for (int k = 0; k < 4; k++) ENSURE_NEAR(g[k], -f[(k + 2) % 4], 1e-12);
}

/* A face across the joint, a step, has the pressure of its place: at the heel, inside, at a bend and at the
   toe, where the tailwater is, and where rounding puts it just beyond either end. */
static void PressureOnAFaceAcrossTheJoint(void)
{
  const UpliftDiagram d = {.n = 3, .s = {0., 4., 10.}, .p = {90., 30., 12.}};
  const struct {
    double at, p;
  } step[] = {{-1e-15, 90}, {0, 90}, {2, 60}, {4, 30}, {7, 21}, {10, 12}, {10 + 2e-15, 12}};
  for (size_t i = 0; i < sizeof step / sizeof step[0]; i++) {
    const PetscReal s[2] = {step[i].at, step[i].at}, x[4] = {step[i].at, 3., step[i].at, 1.};
    PetscReal f[4];
    UpliftOnFace(&d, s, x, 2., f); // x runs down: the block is to the right, the water presses to the right
    for (int k = 0; k < 2; k++) {
      ENSURE_NEAR(f[2 * k], 0.5 * 2. * 2. * step[i].p, 1e-11);
      ENSURE_NEAR(f[2 * k + 1], 0., 1e-12);
    }
  }
}

/* The full head acts along the crack; a crack past the drain loses the drain. */
static void DiagramsOfTheCrack(void)
{
  Load load = {.uplift.rule = UPLIFT_FERC,
               .level = 30,
               .uplift.drain_level = 30,
               .density = 1000,
               .uplift.tailwater = NAN,
               .uplift.gallery = NAN,
               .uplift.drain = 5,
               .uplift.efficiency = 0.5};
  Uplift u = {.toe = {20, 0}, .length = 20};
  UpliftDiagram d;
  UpliftPressure(&load, &u, 10., &d);
  ENSURE(d.n == 3 && d.s[1] == 5);
  ENSURE_NEAR(d.p[1], 3e5 * 0.5 * 15. / 20., 1e-9);
  u.crack = 2;
  UpliftPressure(&load, &u, 10., &d);
  ENSURE(d.n == 4 && d.s[1] == 2 && d.p[1] == 3e5);
  ENSURE_NEAR(d.p[2], 3e5 * 0.5 * 15. / 18., 1e-9);
  u.crack = 8;
  UpliftPressure(&load, &u, 10., &d);
  ENSURE(d.n == 3 && d.s[1] == 8 && d.p[1] == 3e5 && d.p[2] == 0);
}

/* Water in the crack of a joint that falls stands as high as the reservoir: between two waters of one level
   the pressure is that of water at rest, however far the joint is open. In a joint that rises it is H1. */
static void CrackOfALeaningJoint(void)
{
  Load load = {.uplift.rule = UPLIFT_LINEAR,
               .level = 30,
               .uplift.drain_level = 30,
               .density = 1000,
               .uplift.tailwater = 30,
               .uplift.gallery = NAN,
               .uplift.drain = NAN};
  for (int crack = 0; crack <= 20; crack += 5) {
    Uplift u = {.heel = {0, 7}, .toe = {16, -5}, .length = 20, .crack = crack};
    UpliftDiagram d;
    UpliftPressure(&load, &u, 10., &d);
    for (PetscInt i = 0; i < d.n; i++) ENSURE_NEAR(d.p[i], 1e4 * (30. - 7. + 0.6 * d.s[i]), 1e-8);
    ENSURE(d.s[d.n - 1] == 20.);
    u.toe[1] = 19;
    ENSURE_NEAR(UpliftFullHead(&load, &u, crack), 23., 1e-12);
    load.level = 5.; // below the heel: no way into the crack
    u.toe[1] = -5;
    ENSURE(UpliftFullHead(&load, &u, 15.) == 0.);
    load.level = 30.;
  }
}

/* In a joint that rises, the tailwater stands higher above the drain than above the toe: what the drain
   leaves counts from there. Of the total heads, 30 and 25 m, a third of the difference is left. */
static void DrainOfARisingJoint(void)
{
  Load load = {.uplift = {.rule = UPLIFT_NPB,
                          .efficiency = 2. / 3.,
                          .drain_level = 30,
                          .tailwater = 25,
                          .gallery = NAN,
                          .drain = 2},
               .level = 30,
               .density = 1000};
  Uplift u = {.heel = {0, 7}, .toe = {16, 19}, .length = 20};
  const PetscReal y = 7. + 2. * 0.6, total = 25. + 5. / 3. - y;
  UpliftDiagram d;
  UpliftPressure(&load, &u, 10., &d);
  ENSURE(d.n == 3 && d.s[1] == 2.);
  ENSURE_NEAR(d.p[1], 1e4 * (25. - y + (23. - (25. - y)) / 3.), 1e-8); // 11.67 m with the head at the toe
  ENSURE(d.p[1] >= 1e4 * total && d.p[1] < 1.03 * 1e4 * total);
  ENSURE_NEAR(d.p[2], 1e4 * 6., 1e-8);
  u.toe[1] = 7.; // a level joint has one tailwater
  UpliftPressure(&load, &u, 10., &d);
  ENSURE_NEAR(d.p[1], 1e4 * (18. + 5. / 3.), 1e-8);
}

/* At which end of a joint from (0, 0) to (10, 0) a water stands, and at which end of the mirror image. */
static void SideOfAWater(void)
{
  const PetscReal level = 8., ends[4] = {0., 0., 10., 0.}, seam[4] = {-60., -5., 20., 0.},
                  upright[4] = {3., 0., 3., 10.}, image[4] = {-10., 0., 0., 0.},
                  image_seam[4] = {-20., 0., 60., -5.};
  const struct {
    double x[4];
    int side, of_seam;
  } face[] = {
      {{1., 9., 0., 0.}, 0, 0},   // upstream face of the dam; it pushes to the right
      {{0., 9., -1., 0.}, 0, 0},  // one that hangs over
      {{8., 9., 0., 0.}, 0, 0},   // one that lies flat
      {{9., 0., 8., 9.}, 1, 1},   // downstream face
      {{-9., 0., 0., 0.}, 0, 1},  // bottom of the reservoir: the seam is nearer to it by its right end
      {{-5., 0., -5., 9.}, 0, 1}, // downstream face of a cofferdam in front of the dam
      {{0., 9., 1., 9.}, -1, -1}, // dry
  };
  for (size_t i = 0; i < sizeof face / sizeof face[0]; i++) {
    const double *x = face[i].x;
    const PetscReal mirrored[4] = {-x[2], x[3], -x[0], x[1]};
    ENSURE(WaterSide(1, x, level, ends) == face[i].side);
    ENSURE(WaterSide(1, x, level, seam) == face[i].of_seam);
    ENSURE(WaterSide(1, mirrored, level, image) == (face[i].side < 0 ? -1 : 1 - face[i].side));
    ENSURE(WaterSide(1, mirrored, level, image_seam) == (face[i].of_seam < 0 ? -1 : 1 - face[i].of_seam));
  }
  const PetscReal both[8] = {1., 9., 0., 0., 10., 0., 9., 9.}; // a dam that is drowned
  ENSURE(WaterSide(2, both, level, ends) == -1);
  ENSURE(WaterSide(1, (const PetscReal[]){0., 9., 0., 0.}, level, upright) == -1);
}

/* A set that the mesh does not have, for which a scene is refused earlier: no list is read past its end. */
static PetscErrorCode NoSuchSet(void)
{
  char names[1][NAME_LENGTH] = {"base"};
  PetscInt start[3] = {0, 0, 0};
  Load load = {.kind = LOAD_UPLIFT, .name = "uplift", .target = "bass"};
  const Scene scene = {.file = "scene.yaml", .n_loads = 1, .loads = &load};
  const Model m = {.comm = PETSC_COMM_SELF,
                   .mesh.n_face_sets = 1,
                   .mesh.face_set_names = names,
                   .mesh.face_set_start = start};
  const Contacts c = {.n = 0};
  Uplift *all = NULL;
  LEAKS_ALLOWED();
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  const PetscErrorCode code = UpliftCreate(&scene, &m, &c, &all);
  PetscCall(PetscPopErrorHandler());
  LEAKS_COUNT();
  ENSURE(code == PETSC_ERR_PLIB);
  PetscCall(UpliftDestroy(&scene, &all));
  return 0;
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(PressureOnFace);
  RUN_TEST(PressureOnAFaceAcrossTheJoint);
  RUN_TEST(DiagramsOfTheCrack);
  RUN_TEST(CrackOfALeaningJoint);
  RUN_TEST(DrainOfARisingJoint);
  RUN_TEST(SideOfAWater);
  RUN_TEST(NoSuchSet);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}
