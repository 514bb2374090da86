/* element_kernels.h: computes forces, stresses and energies of LANES deformable blocks at once.

   Shape functions by modes. On the 4-node quadrilateral any field x of the vertices (coordinates,
   displacements) is

     x(xi, eta) = x_mean + xi a + eta b + xi eta h,   xi, eta in [-1, 1],
     a = sum xi_i x_i / 4,   b = sum eta_i x_i / 4,   h = sum xi_i eta_i x_i / 4,

   so that x,xi = a + eta h and x,eta = b + xi h. On the triangle a = x_1 - x_0, b = x_2 - x_0 and h = 0 on
   xi, eta >= 0, xi + eta <= 1. The mean moves the block as a whole, so no strain or force depends on it. */
#pragma once
#include "blocks/blocks.h"
#include "base/lanes.h"

typedef struct { /* a symmetric tensor */
  Lanes xx, yy, xy;
} LanesTensor;

typedef struct { /* u_i,j: displacement i along coordinate j */
  Lanes xx, xy, yx, yy;
} LanesGradient;

typedef struct {
  LanesVector a, b, h;
} LanesModes;

typedef struct {
  Lanes lambda, mu;   /* [Pa] */
  Lanes hourglass[3]; /* [Pa] */
  Mask one_point;     /* the block is not ELEMENT_FULL */
} LanesMaterial;

#define GAUSS 0.57735026918962576451 /* 1/sqrt(3): 2x2 points at xi, eta = +-GAUSS, weights 1 */

KERNEL LanesModes ModesAdd(const LanesModes *p, const LanesModes *q)
{
  return (LanesModes){VectorAdd(p->a, q->a), VectorAdd(p->b, q->b), VectorAdd(p->h, q->h)};
}

/* Returns four times the modes. x: the 4 vertices, at (xi, eta) = (-,-), (+,-), (+,+), (-,+). Differences are
   taken first, because they are exact for vertices near each other. */
KERNEL LanesModes Q4FourModes(const LanesVector x[4])
{
  const LanesVector p = VectorSubtract(x[2], x[0]), q = VectorSubtract(x[1], x[3]);
  const LanesVector r = VectorSubtract(x[0], x[1]), s = VectorSubtract(x[2], x[3]);
  return (LanesModes){VectorAdd(p, q), VectorSubtract(p, q), VectorAdd(r, s)};
}

KERNEL LanesModes Q4Modes(const LanesVector x[4])
{
  const LanesModes four = Q4FourModes(x);
  return (LanesModes){VectorScale(0.25, four.a), VectorScale(0.25, four.b), VectorScale(0.25, four.h)};
}

KERNEL LanesModes T3Modes(const LanesVector x[3])
{
  return (LanesModes){VectorSubtract(x[1], x[0]), VectorSubtract(x[2], x[0]), {{0}, {0}}};
}

/* Returns the tangent x,xi at a point; TangentEta returns x,eta. */
KERNEL LanesVector TangentXi(const LanesModes *x, PetscReal eta)
{
  return (LanesVector){x->a.x + eta * x->h.x, x->a.y + eta * x->h.y};
}

KERNEL LanesVector TangentEta(const LanesModes *x, PetscReal xi)
{
  return (LanesVector){x->b.x + xi * x->h.x, x->b.y + xi * x->h.y};
}

/* Computes the gradients g1 of xi and g2 of eta in reference coordinates, from the tangents X1 = X,xi and X2
   = X,eta. They are defined by g_a . X_b = 1 when a = b, else 0. Returns J = det(X1, X2), the area ratio. */
KERNEL Lanes DualBasis(LanesVector X1, LanesVector X2, LanesVector *g1, LanesVector *g2)
{
  const Lanes J = VectorCross(X1, X2), r = 1.0 / J;
  *g1 = (LanesVector){X2.y * r, -X2.x * r};
  *g2 = (LanesVector){-X1.y * r, X1.x * r};
  return J;
}

/* Returns grad u = u,xi (x) g1 + u,eta (x) g2. */
KERNEL LanesGradient DisplacementGradient(LanesVector u1, LanesVector u2, LanesVector g1, LanesVector g2)
{
  return (LanesGradient){u1.x * g1.x + u2.x * g2.x, u1.x * g1.y + u2.x * g2.y, /* along x */
                         u1.y * g1.x + u2.y * g2.x, u1.y * g1.y + u2.y * g2.y};
}

/* Returns the Green-Lagrange strain E = (G + G' + G'G)/2 from the displacement gradient G. It equals (F'F -
   I)/2 without the loss of digits that F'F - I has where the strain is small. With large = 0 the quadratic
   part is left out. */
KERNEL LanesTensor BlockStrain(const LanesGradient *G, int large)
{
  if (!large) return (LanesTensor){G->xx, G->yy, 0.5 * (G->xy + G->yx)};
  return (LanesTensor){G->xx + 0.5 * (G->xx * G->xx + G->yx * G->yx),
                       G->yy + 0.5 * (G->xy * G->xy + G->yy * G->yy),
                       0.5 * ((G->xy + G->yx) + (G->xx * G->xy + G->yx * G->yy))};
}

/* Returns the second Piola-Kirchhoff stress S = lambda tr(E) I + 2 mu E of the block material (Saint
   Venant-Kirchhoff; Hooke's law when E is the small strain). lambda belongs to the plane problem: in plane
   stress it is 2 lambda mu / (lambda + 2 mu).

   docs/extend.md says how to add another material. Stresses and energies go through BlockStress and
   BlockEnergy below. Forces and row sums go through NaturalStress, so the material must be written there,
   too. A material of the deformation gradient can be written in E as well, since S must not change under
   rotation. */
KERNEL LanesTensor BlockStress_StVenantKirchhoff(const LanesMaterial *m, const LanesTensor *E)
{
  const Lanes pressure = m->lambda * (E->xx + E->yy), two_mu = m->mu + m->mu;
  return (LanesTensor){pressure + two_mu * E->xx, pressure + two_mu * E->yy, two_mu * E->xy};
}

/* Returns the energy of this material per reference area and thickness, S : E / 2 [J/m3]. */
KERNEL Lanes BlockEnergy_StVenantKirchhoff(const LanesMaterial *m, const LanesTensor *E)
{
  const LanesTensor S = BlockStress_StVenantKirchhoff(m, E);
  return 0.5 * (S.xx * E->xx + S.yy * E->yy) + S.xy * E->xy;
}

KERNEL LanesTensor BlockStress(const LanesMaterial *m, const LanesTensor *E)
{
  return BlockStress_StVenantKirchhoff(m, E);
}

KERNEL Lanes BlockEnergy(const LanesMaterial *m, const LanesTensor *E)
{
  return BlockEnergy_StVenantKirchhoff(m, E);
}

/* Returns the Cauchy stress F S F' / det F with F = I + G; in small strain S itself. */
KERNEL LanesTensor CauchyStress(const LanesGradient *G, const LanesTensor *S, int large)
{
  if (!large) return *S;
  const LanesVector Fx = {1.0 + G->xx, G->xy}, Fy = {G->yx, 1.0 + G->yy}; /* rows of F */
  const LanesVector SFx = {S->xx * Fx.x + S->xy * Fx.y, S->xy * Fx.x + S->yy * Fx.y};
  const LanesVector SFy = {S->xx * Fy.x + S->xy * Fy.y, S->xy * Fy.x + S->yy * Fy.y};
  const Lanes r = 1.0 / VectorCross(Fx, Fy);
  return (LanesTensor){r * VectorDot(Fx, SFx), r * VectorDot(Fy, SFy), r * VectorDot(Fx, SFy)};
}

/* Natural stress at a point: T_ab = J g_a . S g_b with a, b in xi, eta (stored as xx: xi xi, yy: eta eta,
   xy: xi eta).

   Why it is used: the internal force (10) of vertex i is f_i = int P grad N_i dA with P = F S, and

     J P g_a = J F S g_a = sum_b T_ab F X_b = sum_b T_ab x_b,

   where x_b = X_b + u_b are the present tangents. So neither F nor P is needed. In small strain P = S, and
   x_b is X_b.

   How it is found without g_a and without Cartesian components: twice the strain has the natural components

     D_ab = 2 X_a . E X_b = X_a . u_b + u_a . x_b,   so D_aa = (X_a + x_a) . u_a,

   the metric is G_ab = X_a . X_b with det G = J^2, and T = J G^-1 (lambda tr + 2 mu E) G^-1 in these
   components. Let

     A = J^2 G^-1 = [G_22 -G_12; -G_12 G_11],   d = sum A_ab D_ab,   so that tr E = d / (2 J^2).

   By Cayley and Hamilton A D A = d A - J^2 D*, with D* = [D_22 -D_12; -D_12 D_11], hence

     T = (c A - mu D*) / J,   c = (lambda/2 + mu) d / J^2.

   A change of scale in xi, eta leaves T as it is. */
typedef struct { /* X: tangent in the reference state, u: its change, x: present one; G_aa, D_aa, mu D_aa */
  LanesVector X, u, x;
  Lanes G, D, mu_D;
} LanesTangent;

KERNEL LanesTangent TangentOf(LanesVector X, LanesVector u, Lanes mu, int large)
{
  const LanesVector x = large ? VectorAdd(X, u) : X;
  const Lanes D = VectorDot(VectorAdd(X, x), u);
  return (LanesTangent){X, u, x, VectorDot(X, X), D, mu * D};
}

/* Returns the natural stress from the tangents p, q along xi, eta. D12 belongs to both. modulus: lambda/2 +
   mu. */
KERNEL LanesTensor NaturalStressOf(const LanesTangent *p, const LanesTangent *q, Lanes D12, Lanes modulus,
                                   Lanes mu)
{
  const Lanes r = 1. / VectorCross(p->X, q->X), G12 = VectorDot(p->X, q->X);
  const Lanes d = q->G * p->D + p->G * q->D - (G12 + G12) * D12, c = modulus * (r * r) * d;
  return (LanesTensor){(c * q->G - q->mu_D) * r, (c * p->G - p->mu_D) * r, (mu * D12 - c * G12) * r};
}

KERNEL LanesTensor NaturalStress(const LanesTangent *p, const LanesTangent *q, Lanes modulus, Lanes mu)
{
  return NaturalStressOf(p, q, VectorDot(p->X, q->u) + VectorDot(p->u, q->x), modulus, mu);
}

/* Returns the natural stress at the centre of a block. */
KERNEL LanesTensor CentreStress(const LanesModes *X, const LanesModes *u, const LanesMaterial *m, int large)
{
  const LanesTangent p = TangentOf(X->a, u->a, m->mu, large), q = TangentOf(X->b, u->b, m->mu, large);
  return NaturalStress(&p, &q, 0.5 * m->lambda + m->mu, m->mu);
}

/* Computes the forces f on the vertices from the forces R1, R2, RH on the modes. */
KERNEL void ModeForces(LanesVector R1, LanesVector R2, LanesVector RH, LanesVector f[4])
{
  const LanesVector sum = VectorAdd(R1, R2), difference = VectorSubtract(R1, R2);
  f[0] = VectorSubtract(RH, sum);
  f[1] = VectorSubtract(difference, RH);
  f[2] = VectorAdd(RH, sum);
  f[3] = (LanesVector){-(difference.x + RH.x), -(difference.y + RH.y)};
}

/* Computes the forces on the vertices of the 4-node block from the natural stresses at its points (-,-),
   (+,-), (+,+), (-,+). a, b, k: see Q4Force. */
KERNEL void Q4Sum(const LanesTensor T[4], LanesVector a, LanesVector b, LanesVector k, LanesVector f[4])
{
  /* sums over a row of points (below, above) or a column (left, right) */
  const Lanes below = T[0].xx + T[1].xx, above = T[2].xx + T[3].xx, left = T[0].yy + T[3].yy,
              right = T[1].yy + T[2].yy;
  const Lanes low = T[0].xy + T[1].xy, high = T[2].xy + T[3].xy, p = T[1].xy - T[0].xy, q = T[2].xy - T[3].xy;
  const Lanes t11 = below + above, t22 = left + right, t12 = low + high;
  const Lanes s1 = (above - below) + (p + q), s2 = (high - low) + (right - left), d = q - p;
  const Lanes s3 = t11 + t22 + (d + d);
  const LanesVector R1 = {t11 * a.x + t12 * b.x + s1 * k.x, t11 * a.y + t12 * b.y + s1 * k.y};
  const LanesVector R2 = {t12 * a.x + t22 * b.x + s2 * k.x, t12 * a.y + t22 * b.y + s2 * k.y};
  const LanesVector RH = {s1 * a.x + s2 * b.x + s3 * k.x, s1 * a.y + s2 * b.y + s3 * k.y};
  ModeForces(R1, R2, VectorScale(GAUSS, RH), f);
}

/* Computes the internal force (10) of the 4-node block, 2x2 Gauss. X, u: at the vertices; f: forces there.

   N_i = 1/4 + (xi_i xi + eta_i eta + xi_i eta_i xi eta)/4, so f_i = (xi_i R1 + eta_i R2 + xi_i eta_i RH)/4
   with R1 = sum T11 x1 + T12 x2,   R2 = sum T12 x1 + T22 x2,   RH = sum eta (T11 x1 + T12 x2) + xi (T12 x1 +
   T22 x2) over the Gauss points (times the thickness). With x1 = a + eta h and x2 = b + xi h of the current
   modes, xi, eta = +-g and k = g h, this is
     R1 = t11 a + t12 b + s1 k,   R2 = t12 a + t22 b + s2 k,   RH = g (s1 a + s2 b + s3 k),   t_ab = sum T_ab,
     s1 = sum (eta T11 + xi T12)/g,  s2 = sum (eta T12 + xi T22)/g,  s3 = t11 + t22 + 2 sum xi eta T12/g^2.
   Here a, b, h are four times the modes: T does not change, and R is four times as large. The factor of it
   all, w, is in the moduli. */
KERNEL void Q4Force(const LanesVector X[4], const LanesVector u[4], const LanesMaterial *m,
                    PetscReal thickness, int large, LanesVector f[4])
{
  const PetscReal w = 0.0625 * thickness;
  const Lanes mu = w * m->mu, modulus = 0.5 * w * m->lambda + mu;
  const LanesModes XM = Q4FourModes(X), uM = Q4FourModes(u);
  const LanesVector Xk = VectorScale(GAUSS, XM.h), uk = VectorScale(GAUSS, uM.h);
  /* tangents along xi below and above the middle, along eta left and right of it */
  const LanesTangent b1 = TangentOf(VectorSubtract(XM.a, Xk), VectorSubtract(uM.a, uk), mu, large),
                     a1 = TangentOf(VectorAdd(XM.a, Xk), VectorAdd(uM.a, uk), mu, large),
                     l2 = TangentOf(VectorSubtract(XM.b, Xk), VectorSubtract(uM.b, uk), mu, large),
                     r2 = TangentOf(VectorAdd(XM.b, Xk), VectorAdd(uM.b, uk), mu, large);
  const LanesTensor T[4] = {NaturalStress(&b1, &l2, modulus, mu), NaturalStress(&b1, &r2, modulus, mu),
                            NaturalStress(&a1, &r2, modulus, mu), NaturalStress(&a1, &l2, modulus, mu)};
  const LanesVector a = large ? VectorAdd(XM.a, uM.a) : XM.a, b = large ? VectorAdd(XM.b, uM.b) : XM.b,
                    k = large ? VectorAdd(Xk, uk) : Xk;
  Q4Sum(T, a, b, k, f);
}

/* Blocks of one point. The stress at the centre gives the forces of every constant strain exactly. Bending
   adds the displacement xi eta q, with q = u_h - grad(u) X_h at the centre. This q is the hourglass mode
   minus its linear part; it is zero in any constant strain and in any rigid motion. It stores the energy
   p.C p/2 in p = F'q, its components in the directions of the material, so that the block is objective.
   With

     h = xi eta,   H = int grad h (x) grad h dA = A/3 (g1 (x) g1 + g2 (x) g2),   Jacobian of the centre:

   ELEMENT_BENDING: the assumed strain

     e_xx = h,x p_x - nu h,y p_y,   e_yy = h,y p_y - nu h,x p_x,   e_xy = 0   (E, nu of the plane problem)

   leaves out the parasitic shear that the full block has in bending, and leaves the strain across free. With
   sigma_xx = E h,x p_x and sigma_yy = E h,y p_y

     C = E [H_xx, -nu H_xy; -nu H_xy, H_yy].

   ELEMENT_REDUCED: C = k E (H_xx + H_yy)/2 I, with the coefficient k; it only keeps hourglass modes small.

   Both have the form C = [c0 H_xx + c1 H_yy, c2 H_xy; c2 H_xy, c1 H_xx + c0 H_yy], c = hourglass. */
typedef struct {
  Lanes J;
  LanesVector g1, g2;
  LanesGradient G;     /* at the centre */
  LanesVector q, p, c; /* c = C p */
} LanesHourglass;

KERNEL LanesHourglass Hourglass(const LanesModes *X, const LanesModes *u, const LanesModes *x,
                                const LanesMaterial *m)
{
  LanesHourglass o;
  o.J = DualBasis(X->a, X->b, &o.g1, &o.g2);
  o.G = DisplacementGradient(u->a, u->b, o.g1, o.g2);
  o.q = (LanesVector){u->h.x - (o.G.xx * X->h.x + o.G.xy * X->h.y),
                      u->h.y - (o.G.yx * X->h.x + o.G.yy * X->h.y)};
  const Lanes aq = VectorDot(x->a, o.q), bq = VectorDot(x->b, o.q), third = o.J * (4. / 3.);
  o.p = (LanesVector){o.g1.x * aq + o.g2.x * bq, o.g1.y * aq + o.g2.y * bq};
  const Lanes xx = third * (o.g1.x * o.g1.x + o.g2.x * o.g2.x),
              yy = third * (o.g1.y * o.g1.y + o.g2.y * o.g2.y),
              xy = third * (o.g1.x * o.g1.y + o.g2.x * o.g2.y) * m->hourglass[2];
  o.c = (LanesVector){(m->hourglass[0] * xx + m->hourglass[1] * yy) * o.p.x + xy * o.p.y,
                      xy * o.p.x + (m->hourglass[1] * xx + m->hourglass[0] * yy) * o.p.y};
  return o;
}

/* Computes the internal force of the block of one point, from the stress T at the centre and from p.C p/2,
   for which dp = F'dq + dF'q, dq = dx_h - dF X_h, dF = da (x) g1 + db (x) g2, where a, b, h are the present
   modes. In small strain a and b are the modes of the reference state, and q is not in the force. */
KERNEL void Q4OnePointSum(const LanesModes *X, const LanesModes *x, const LanesHourglass *o,
                          const LanesTensor *T, PetscReal thickness, int large, LanesVector f[4])
{
  const Lanes c1 = VectorDot(o->g1, o->c), c2 = VectorDot(o->g2, o->c);
  const Lanes h1 = VectorDot(o->g1, X->h), h2 = VectorDot(o->g2, X->h);
  const LanesVector Fc = {x->a.x * c1 + x->b.x * c2, x->a.y * c1 + x->b.y * c2};
  const Lanes q1 = large ? c1 : 0. * c1, q2 = large ? c2 : 0. * c2;
  const PetscReal w = 0.25 * thickness;
  const LanesVector R1 = {w * (4. * (T->xx * x->a.x + T->xy * x->b.x) - h1 * Fc.x + q1 * o->q.x),
                          w * (4. * (T->xx * x->a.y + T->xy * x->b.y) - h1 * Fc.y + q1 * o->q.y)};
  const LanesVector R2 = {w * (4. * (T->xy * x->a.x + T->yy * x->b.x) - h2 * Fc.x + q2 * o->q.x),
                          w * (4. * (T->xy * x->a.y + T->yy * x->b.y) - h2 * Fc.y + q2 * o->q.y)};
  ModeForces(R1, R2, VectorScale(w, Fc), f);
}

KERNEL void Q4OnePointForce(const LanesVector X[4], const LanesVector u[4], const LanesMaterial *m,
                            PetscReal thickness, int large, LanesVector f[4])
{
  const LanesModes XM = Q4Modes(X), uM = Q4Modes(u);
  const LanesModes x = large ? ModesAdd(&XM, &uM) : XM;
  const LanesHourglass o = Hourglass(&XM, &uM, &x, m);
  const LanesTensor T = CentreStress(&XM, &uM, m, large);
  Q4OnePointSum(&XM, &x, &o, &T, thickness, large, f);
}

/* Computes the forces on the vertices of the 3-node block from its natural stress and its tangents. It has
   one point of weight 1/2, and N = (1 - xi - eta, xi, eta). */
KERNEL void T3Sum(const LanesTensor *T, LanesVector x1, LanesVector x2, PetscReal thickness, LanesVector f[3])
{
  const PetscReal w = 0.5 * thickness;
  f[1] = (LanesVector){w * (T->xx * x1.x + T->xy * x2.x), w * (T->xx * x1.y + T->xy * x2.y)};
  f[2] = (LanesVector){w * (T->xy * x1.x + T->yy * x2.x), w * (T->xy * x1.y + T->yy * x2.y)};
  f[0] = (LanesVector){-(f[1].x + f[2].x), -(f[1].y + f[2].y)};
}

/* Computes the internal force (10) of the 3-node block. */
KERNEL void T3Force(const LanesVector X[3], const LanesVector u[3], const LanesMaterial *m,
                    PetscReal thickness, int large, LanesVector f[3])
{
  const LanesModes XM = T3Modes(X), uM = T3Modes(u);
  const LanesVector x1 = large ? VectorAdd(XM.a, uM.a) : XM.a, x2 = large ? VectorAdd(XM.b, uM.b) : XM.b;
  const LanesTensor T = CentreStress(&XM, &uM, m, large);
  T3Sum(&T, x1, x2, thickness, f);
}

/* Computes the internal force of either shape. n_nodes is a constant where speed matters. */
KERNEL void ElementForce(int n_nodes, const LanesVector *X, const LanesVector *u, const LanesMaterial *m,
                         PetscReal thickness, int large, LanesVector *f)
{
  if (n_nodes == 3) {
    T3Force(X, u, m, thickness, large, f);
    return;
  }
  if (!Any(m->one_point)) {
    Q4Force(X, u, m, thickness, large, f);
    return;
  }
  Q4OnePointForce(X, u, m, thickness, large, f);
  if (!Any(~m->one_point)) return;
  LanesVector full[4];
  Q4Force(X, u, m, thickness, large, full);
  for (int i = 0; i < 4; i++)
    f[i] = (LanesVector){Select(m->one_point, f[i].x, full[i].x), Select(m->one_point, f[i].y, full[i].y)};
}

KERNEL LanesModes ElementModes(int n_nodes, const LanesVector *x)
{
  return n_nodes == 4 ? Q4Modes(x) : T3Modes(x);
}

/* Finds what stresses and energies need at a point: area ratio J, displacement gradient G, strain E. */
KERNEL void PointStrain(const LanesModes *X, const LanesModes *u, PetscReal xi, PetscReal eta, int large,
                        Lanes *J, LanesGradient *G, LanesTensor *E)
{
  LanesVector g1, g2;
  *J = DualBasis(TangentXi(X, eta), TangentEta(X, xi), &g1, &g2);
  *G = DisplacementGradient(TangentXi(u, eta), TangentEta(u, xi), g1, g2);
  *E = BlockStrain(G, large);
}

/* Returns the energy of the 4-node block per thickness. */
KERNEL Lanes Q4Energy(const LanesModes *X, const LanesModes *u, const LanesMaterial *m, int large)
{
  Lanes J, sum = {0.};
  LanesGradient G;
  LanesTensor E;
  for (int p = 0; p < 4; p++) {
    PointStrain(X, u, p == 0 || p == 3 ? -GAUSS : GAUSS, p < 2 ? -GAUSS : GAUSS, large, &J, &G, &E);
    sum += J * BlockEnergy(m, &E);
  }
  if (!Any(m->one_point)) return sum;
  const LanesModes x = large ? ModesAdd(X, u) : *X;
  const LanesHourglass o = Hourglass(X, u, &x, m);
  PointStrain(X, u, 0., 0., large, &J, &G, &E);
  return Select(m->one_point, 4. * J * BlockEnergy(m, &E) + 0.5 * VectorDot(o.p, o.c), sum);
}

/* Computes the lumped masses per density and thickness. The row sums (27) of the mass matrix (26) are m_i =
   int N_i dA, since the N_j sum to 1. On the quadrilateral J = a x b + xi (a x h) + eta (h x b) is linear,
   so the 2x2 sum (26) gives these integrals exactly. */
KERNEL void ElementAreas(int n_nodes, const LanesVector *X, Lanes *area)
{
  const LanesModes x = ElementModes(n_nodes, X);
  const Lanes c = VectorCross(x.a, x.b);
  if (n_nodes == 3) {
    for (int i = 0; i < 3; i++) area[i] = c * (1.0 / 6.0);
    return;
  }
  const Lanes p = VectorCross(x.a, x.h) * (1.0 / 3.0), q = VectorCross(x.h, x.b) * (1.0 / 3.0);
  area[0] = c - p - q;
  area[1] = c + p - q;
  area[2] = c + p + q;
  area[3] = c - p + q;
}

/* ---- input of loops over blocks */

/* Loads the material of LANES blocks with groups g. h: model->hourglass; NULL when all blocks are
   ELEMENT_FULL. Where speed matters callers pass NULL as a constant, and the compiler leaves the rest out. */
KERNEL LanesMaterial LoadMaterialOf(const Model *model, const PetscReal *h, const PetscInt *g)
{
  const LanesVector lame = GatherVertex(&model->materials.lame->lambda, g);
  if (!h) return (LanesMaterial){lame.x, lame.y, {{0.}, {0.}, {0.}}, {0}};
  const Lanes c0 = GatherThird(h, g), c1 = GatherThird(h + 1, g), c2 = GatherThird(h + 2, g);
  return (LanesMaterial){lame.x, lame.y, {c0, c1, c2}, c0 > 0.};
}

KERNEL LanesMaterial LoadMaterial(const Model *model, const PetscInt *g)
{
  return LoadMaterialOf(model, model->materials.hourglass, g);
}

/* Returns the vertices of LANES elements from element `first` on; vertex i of a lane stands at [i * BATCH +
   lane]. */
KERNEL const PetscInt *LaneVertices(const Elements *e, int n_nodes, PetscInt first)
{
  const size_t i = (size_t)first;
  return e->vertex + (i / BATCH) * n_nodes * BATCH + i % BATCH;
}

/* Gathers the coordinates and displacements for the strain of LANES blocks. Strain of blocks that were
   placed on others counts from the displacements of their vertices then: u - u_0, in large strain from the
   places X + u_0, so F is F F_0^-1. */
KERNEL void GatherBlocks(const Model *model, const Elements *e, int n_nodes, PetscInt first, int large,
                         const PetscReal *u, LanesVector *X, LanesVector *U)
{
  const PetscInt *vertex = LaneVertices(e, n_nodes, first);
  Gather(n_nodes, model->mesh.X, vertex, X);
  Gather(n_nodes, u, vertex, U);
  if (!e->placed) return;
  const PetscReal *x = e->placed + (vertex - e->vertex), *y = x + (size_t)n_nodes * e->n_padded;
  for (int i = 0; i < n_nodes; i++) {
    const LanesVector u_0 = {LoadLanes(x + i * BATCH), LoadLanes(y + i * BATCH)};
    U[i] = VectorSubtract(U[i], u_0);
    if (large) X[i] = VectorAdd(X[i], u_0);
  }
}
