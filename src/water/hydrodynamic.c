/* hydrodynamic.c: computes the hydrodynamic pressure of incompressible water, without surface waves, whose
   bottom and wall move together.

   westergaard  p = 7/8 rho a_n sqrt(H z), a_n the acceleration normal to the face, so each face counts by its
                own slope (Westergaard 1933, on faces that lean in the usual generalised form)
   zangar       p = rho a H C_m/2 [s (2 - s) + sqrt(s (2 - s))], s = z/H, C_m = 0.7412 - 0.0073 lean/degree
                (Zangar 1952); one slope for the whole wall, the slope of the line from the water's edge to
                the lowest point, and none where the upper half of the wall or more is vertical */
#include "water/hydrodynamic.h"

static const PetscReal VERTICAL = 1.;   /* [degree] from the vertical: smaller angles count as vertical */
static const PetscReal LEANS = 15.;     /* [degree] angle from which a run warns of westergaard */
static const PetscReal OVERHANGS = -5.; /* [degree] angle below which zangar has no coefficient */

/* ---- the wall */

static PetscReal degrees(PetscReal radians)
{
  return radians * (180. / PETSC_PI);
}

/* Returns x of the direction from the wall to its water; -1: the water is on the left. normal: see
   WetWall. */
static PetscReal side_of(const PetscReal normal[2])
{
  return -normal[0] > normal[1] ? -1. : 1.;
}

/* Finds the ends of a face: x, y, x, y. Returns whether it is wet. */
static PetscBool wet_face(const Model *m, PetscInt face, PetscReal level, PetscReal x[4])
{
  FaceCoordinates(m, NULL, face, x);
  return (PetscBool)(PetscMin(x[1], x[3]) < level);
}

/* Returns x of a face at elevation y; beyond the face x of its nearer end. */
static PetscReal x_at(const PetscReal x[4], PetscReal y)
{
  if (x[1] == x[3]) return x[0];
  return x[0] + PetscClipInterval((y - x[1]) / (x[3] - x[1]), 0., 1.) * (x[2] - x[0]);
}

/* Computes minima: 0 lowest point, 1 highest wet point (negative), 2 top of the part that is not vertical
   (negative), 3 normals, 4 normals (negative). */
static void find_bounds(const Model *m, PetscInt n_faces, const PetscInt *faces, PetscReal level,
                        PetscReal least[5])
{
  PetscReal x[4];
  for (int k = 0; k < 5; k++) least[k] = k < 3 ? PETSC_MAX_REAL : 1.;
  for (PetscInt i = 0; i < n_faces; i++) {
    const PetscBool wet = wet_face(m, faces[i], level, x);
    const PetscReal top = PetscMin(level, PetscMax(x[1], x[3])),
                    n = (x[3] - x[1]) / PetscHypotReal(x[2] - x[0], x[3] - x[1]);
    least[0] = PetscMin(least[0], PetscMin(x[1], x[3]));
    if (!wet) continue;
    least[1] = PetscMin(least[1], -top);
    if (degrees(PetscAcosReal(PetscMin(1., PetscAbsReal(n)))) > VERTICAL) least[2] = PetscMin(least[2], -top);
    least[3] = PetscMin(least[3], n), least[4] = PetscMin(least[4], -n);
  }
}

/* Computes the range of x of the faces at the elevations y[0] and y[1]: least, largest (negative) of each. */
static void find_ends(const Model *m, PetscInt n_faces, const PetscInt *faces, PetscReal level,
                      const PetscReal y[2], PetscReal least[4])
{
  const PetscReal near = 1e-9 * (y[1] - y[0]);
  PetscReal x[4];
  for (int k = 0; k < 4; k++) least[k] = PETSC_MAX_REAL;
  for (PetscInt i = 0; i < n_faces; i++) {
    if (!wet_face(m, faces[i], level, x)) continue;
    for (int e = 0; e < 2; e++) {
      if (PetscMin(x[1], x[3]) > y[e] + near || PetscMax(x[1], x[3]) < y[e] - near) continue;
      const PetscBool flat = (PetscBool)(PetscAbsReal(x[3] - x[1]) <= near);
      const PetscReal at[2] = {flat ? x[0] : x_at(x, y[e]), flat ? x[2] : x_at(x, y[e])};
      least[2 * e] = PetscMin(least[2 * e], PetscMin(at[0], at[1]));
      least[2 * e + 1] = PetscMin(least[2 * e + 1], -PetscMax(at[0], at[1]));
    }
  }
}

PetscErrorCode WetWallFind(const Model *m, const Load *load, WetWall *wall)
{
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, load->target, &n);
  PetscReal least[5], ends[4];
  PetscFunctionBeginUser;
  find_bounds(m, n, faces, load->level, least);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, least, 5, MPIU_REAL, MPI_MIN, m->comm));
  const PetscReal y[2] = {least[0], -least[1]}, bottom = load->hydro.bottom;
  *wall = (WetWall){.rule = load->hydro.rule, .level = load->level, .lowest = y[0]};
  wall->depth = load->level - (PetscIsNanReal(bottom) ? y[0] : bottom);
  wall->normal[0] = least[3], wall->normal[1] = -least[4];
  if (least[3] > -least[4]) PetscFunctionReturn(PETSC_SUCCESS); // dry
  find_ends(m, n, faces, load->level, y, ends);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ends, 4, MPIU_REAL, MPI_MIN, m->comm));
  // if the faces include a bed, the foot of the wall counts
  const PetscReal top = 0.5 * (ends[2] - ends[3]), foot = PetscClipInterval(top, ends[0], -ends[1]),
                  side = side_of(wall->normal);
  wall->lean = degrees(PetscAtan2Real(side * (foot - top), y[1] - y[0]));
  if (load->hydro.rule == HYDRO_ZANGAR && y[1] + least[2] >= 0.5 * (y[1] - y[0])) wall->lean = 0.;
  wall->largest = 0.7412 - 0.0073 * PetscMax(0., wall->lean);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void WetWallRefuse(const Scene *scene, const Load *load, const WetWall *wall, char message[MESSAGE_LENGTH])
{
  const PetscReal n[2] = {wall->normal[0], wall->normal[1]};
  char key[LABEL_LENGTH];
  message[0] = '\0';
  if (n[0] > n[1]) {
    PetscCallAbort(PETSC_COMM_SELF, PetscSNPrintf(key, sizeof(key), "loads.%s.level", load->name));
    Complain(message, scene->file, load->line, key, "%g is not above the lowest point of the faces, %g [m]",
             (double)load->level, (double)wall->lowest);
    return;
  }
  if (load->hydro.bottom > wall->lowest + 1e-9 * wall->depth) {
    PetscCallAbort(PETSC_COMM_SELF, PetscSNPrintf(key, sizeof(key), "loads.%s.bottom", load->name));
    Complain(message, scene->file, load->line, key, "%g is above the lowest point of the faces, %g [m]",
             (double)load->hydro.bottom, (double)wall->lowest);
    return;
  }
  if (load->hydro.rule != HYDRO_ZANGAR) return;
  PetscCallAbort(PETSC_COMM_SELF, PetscSNPrintf(key, sizeof(key), "loads.%s.rule", load->name));
  if (PetscMin(-n[0], n[1]) > 0.1)
    Complain(
        message, scene->file, load->line, key,
        "zangar takes the faces as one wall, and some of these look upstream, some downstream: give each "
        "side a load");
  else if (wall->lean < OVERHANGS)
    Complain(
        message, scene->file, load->line, key,
        "zangar has no number for faces that overhang the water, these by %.3g degrees: choose westergaard",
        (double)-wall->lean);
}

/* ---- the pressure */

PetscReal HydrodynamicPressure(const WetWall *wall, PetscReal s)
{
  s = PetscClipInterval(s, 0., 1.);
  if (wall->rule == HYDRO_WESTERGAARD) return 0.875 * PetscSqrtReal(s);
  return 0.5 * wall->largest * (s * (2. - s) + PetscSqrtReal(s * (2. - s)));
}

/* Returns the excess from the normal force over rho a H^2 of potential flow on a straight wall; the excess of
   westergaard is 7/12 at all angles. */
PetscReal WestergaardExcess(PetscReal lean)
{
  static const PetscReal exact[] = {0.5427, 0.4712, 0.4323, 0.4167, 0.4211}; // at 0, 15, 30, 45, 60 degrees
  const PetscReal at = PetscClipInterval(lean / 15., 0., 4.), from = PetscMin(PetscFloorReal(at), 3.);
  const PetscReal *e = exact + (int)from;
  return 7. / 12. / (e[0] + (at - from) * (e[1] - e[0])) - 1.;
}

void WetWallWarn(const Load *load, const WetWall *wall)
{
  if (load->hydro.rule != HYDRO_WESTERGAARD || wall->lean <= LEANS) return;
  Warn("loads.%s: its faces lean %.0f degrees from the vertical, where westergaard "
       "gives %.0f %% more than potential flow: take rule: zangar",
       load->name, (double)wall->lean, 100. * (double)WestergaardExcess(wall->lean));
}

PetscReal SuctionDepth(const WetWall *wall, PetscReal k_h)
{
  const PetscReal k = wall->rule == HYDRO_ZANGAR ? k_h * side_of(wall->normal)
                                                 : PetscMax(k_h * wall->normal[0], k_h * wall->normal[1]);
  PetscReal pulls = 0., presses = 1.;
  if (k <= 0.) return 0.;
  if (k * HydrodynamicPressure(wall, 1.) >= 1.) return wall->depth;
  for (int i = 0; i < 60; i++) { // the ratio of pressure to depth decreases with depth
    const PetscReal s = 0.5 * (pulls + presses);
    *(k * HydrodynamicPressure(wall, s) > s ? &pulls : &presses) = s;
  }
  return pulls * wall->depth;
}

/* Returns the cosine between the normal of an inclined wall and x, because zangar is given for an
   acceleration along x. */
static PetscReal along_normal(const WetWall *wall)
{
  return wall->rule == HYDRO_ZANGAR ? PetscCosReal(PetscMax(0., wall->lean) * (PETSC_PI / 180.)) : 1.;
}

/* Returns the pressure over density and r, where r is the root of the depth; linear in r for westergaard. */
static PetscReal over_root(const WetWall *wall, PetscReal r, PetscReal g, PetscReal a_n)
{
  const PetscReal near = PetscMax(r, 1e-6 * PetscSqrtReal(wall->depth)), s = near * near / wall->depth;
  return g * near + wall->depth * HydrodynamicPressure(wall, s) / along_normal(wall) * a_n / near;
}

PetscReal PressureOfHalf(const PetscReal x[2], const PetscReal middle[2], const WetWall *wall,
                         PetscReal density, PetscReal g, PetscReal a_n, PetscReal at[2], PetscReal *below)
{
  enum { PARTS_OF_HALF = 16 };
  const PetscReal z[2] = {wall->level - x[1], wall->level - middle[1]}, rise = PetscAbsReal(z[1] - z[0]),
                  length = PetscHypotReal(middle[0] - x[0], middle[1] - x[1]);
  const PetscBool flat = (PetscBool)(rise <= 1e-9 * length);
  const PetscReal from = PetscSqrtReal(PetscMax(0., PetscMin(z[0], z[1]))),
                  to = PetscSqrtReal(PetscMax(0., PetscMax(z[0], z[1])));
  PetscReal least = PETSC_MAX_REAL;
  *below = 0.;
  for (int i = 0; i <= PARTS_OF_HALF; i++) {
    const PetscReal r = from + (to - from) * i / PARTS_OF_HALF, f = over_root(wall, r, g, a_n);
    if (density * f * r < least) {
      const PetscReal part = flat ? 0. : (r * r - z[0]) / (z[1] - z[0]);
      least = density * f * r;
      for (int k = 0; k < 2; k++) at[k] = x[k] + part * (middle[k] - x[k]);
    }
    if (i == PARTS_OF_HALF || flat) continue;
    const PetscReal next = from + (to - from) * (i + 1) / PARTS_OF_HALF,
                    f_next = over_root(wall, next, g, a_n);
    PetscReal a = r, b = next; // limits of the negative stretch
    if (f >= 0. && f_next >= 0.) continue;
    if (f >= 0.) a = r + (next - r) * f / (f - f_next);
    if (f_next >= 0.) b = r + (next - r) * f / (f - f_next);
    *below += (b * b - a * a) * length / rise;
  }
  if (flat && least < 0.) *below = length;
  return least;
}

/* Points and weights of Gauss's rule on 0..1. */
static const PetscReal GAUSS[8][2] = {
    {0.019855071751231856, 0.050614268145188130}, {0.10166676129318664, 0.11119051722668724},
    {0.23723379504183550, 0.15685332293894364},   {0.40828267875217510, 0.18134189168918099},
    {0.59171732124782490, 0.18134189168918099},   {0.76276620495816450, 0.15685332293894364},
    {0.89833323870681336, 0.11119051722668724},   {0.98014492824876814, 0.050614268145188130}};

/* An integration point of a wet face. */
typedef struct {
  PetscReal at;     /* [-] 0..1 along the face */
  PetscReal weight; /* [-] fraction of the length of the face */
  PetscReal over;   /* [-] pressure over density, acceleration and depth of a vertical wall */
} WetPoint;

/* Computes the integration points of a face. Returns their number, 0 for a dry face. They are Gauss points
   in r = sqrt(depth), in which the pressure is smooth: exact for westergaard, to 1e-9 for zangar. */
static int wet_points(const PetscReal x[4], const WetWall *wall, WetPoint points[8])
{
  const PetscReal z[2] = {wall->level - x[1], wall->level - x[3]};
  PetscReal from = 0., to = 1.;
  if (z[0] <= 0. && z[1] <= 0.) return 0;
  if (z[0] < 0.) from = z[0] / (z[0] - z[1]);
  if (z[1] < 0.) to = z[0] / (z[0] - z[1]);
  const PetscReal a = PetscSqrtReal(PetscMax(z[0], 0.)), b = PetscSqrtReal(PetscMax(z[1], 0.));
  for (int g = 0; g < 8; g++) {
    const PetscReal r = a + GAUSS[g][0] * (b - a), along = GAUSS[g][0] * (r + a) / (a + b);
    points[g].at = from + (to - from) * along;
    points[g].weight = (to - from) * GAUSS[g][1] * 2. * r / (a + b);
    points[g].over = HydrodynamicPressure(wall, r * r / wall->depth);
  }
  return 8;
}

void HydrodynamicOnFace(const PetscReal x[4], const WetWall *wall, PetscReal push, PetscReal thickness,
                        PetscReal f[4])
{
  const PetscReal n = (x[3] - x[1]) / PetscHypotReal(x[2] - x[0], x[3] - x[1]);
  WetPoint point[8];
  const int wet = wet_points(x, wall, point);
  for (int i = 0; i < 4; i++) f[i] = 0.;
  // water left of the wall, n < 0, presses against inertia to the right; water on its right pulls
  const PetscReal towards = wall->rule == HYDRO_WESTERGAARD ? -n : -side_of(wall->normal);
  for (int g = 0; g < wet; g++) {
    const PetscReal p = towards * push * wall->depth * point[g].over;
    PushOnFace(x, point[g].at, point[g].weight * p * thickness, f);
  }
}

void HydrodynamicMass(const PetscReal x[4], const WetWall *wall, PetscReal density, PetscReal k[16])
{
  const PetscReal length = PetscHypotReal(x[2] - x[0], x[3] - x[1]),
                  n[2] = {(x[3] - x[1]) / length, (x[0] - x[2]) / length};
  const PetscReal full = density * length * wall->depth / along_normal(wall);
  WetPoint point[8];
  const int wet = wet_points(x, wall, point);
  for (int i = 0; i < 16; i++) k[i] = 0.;
  for (int g = 0; g < wet; g++) {
    const PetscReal N[2] = {1. - point[g].at, point[g].at}, mass = full * point[g].weight * point[g].over;
    for (int i = 0; i < 4; i++)
      for (int j = 0; j < 4; j++) k[4 * i + j] += mass * N[i / 2] * n[i % 2] * N[j / 2] * n[j % 2];
  }
}
