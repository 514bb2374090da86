/* joint_rows.c: finds which row of the joints table a contact has; refuses rows that no contact has. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* Returns the row of the joint for a pair of groups, 0: none. */
static PetscInt row_of_groups(const Scene *scene, const char *a, const char *b)
{
  for (PetscInt j = 1; j < scene->n_joints; j++) {
    const char *name = scene->joints[j].name, *plus = strchr(name, '+');
    if (!plus) continue;
    const size_t na = strlen(a), nb = strlen(b), first = (size_t)(plus - name);
    if (first == na && !strncmp(name, a, na) && !strcmp(plus + 1, b)) return j;
    if (first == nb && !strncmp(name, b, nb) && !strcmp(plus + 1, a)) return j;
  }
  return 0;
}

PetscInt JointBetween(const Scene *scene, const Model *m, PetscInt jf, PetscInt a, PetscInt jg, PetscInt b)
{
  if (jf >= 0 || jg >= 0)
    return jf < 0 || (jg >= 0 && m->materials.joint_turn[jg] < m->materials.joint_turn[jf]) ? jg : jf;
  const PetscInt row = row_of_groups(scene, m->materials.names[a], m->materials.names[b]);
  return row || !m->materials.later_joint ? row : m->materials.later_joint[a * m->materials.n_groups + b];
}

PetscInt JointOfPair(const Scene *scene, const Model *m, PetscInt f, PetscInt g)
{
  const Faces *faces = &m->faces;
  return JointBetween(scene, m, faces->joint[f], faces->group[f], faces->joint[g], faces->group[g]);
}

/* ---- contacts that come later */

/* Collective. Finds which rows contacts have. used: (n_groups, n_groups, n_joints) 1 where contacts of the
   two groups have the row. */
static PetscErrorCode rows_in_use(const Scene *scene, const Model *m, const Contacts *c, PetscInt *used)
{
  const PetscInt n = m->materials.n_groups;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || c->key[2 * i + 1] < 0) continue;
    const PetscInt f = FaceRow(m, c->key[2 * i]), g = FaceRow(m, c->key[2 * i + 1]);
    if (f < 0 || g < 0) continue;
    const PetscInt a = m->faces.group[f], b = m->faces.group[g];
    used[(a * n + b) * scene->n_joints + c->joint[i]] = 1;
    used[(b * n + a) * scene->n_joints + c->joint[i]] = 1;
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, used, (PetscMPIInt)(n * n * scene->n_joints), MPIU_INT, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the bodies of each group that have faces without a named joint. range: (n_groups, 2)
   minus the lowest number, and the highest number, of these bodies. */
static PetscErrorCode bodies_in_reach(const Model *m, PetscInt *range)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < 2 * m->materials.n_groups; i++) range[i] = PETSC_MIN_INT;
  for (PetscInt f = 0; f < m->faces.n; f++) {
    PetscInt *r = range + 2 * m->faces.group[f];
    if (m->faces.joint[f] >= 0) continue;
    r[0] = PetscMax(r[0], -m->faces.body[f]), r[1] = PetscMax(r[1], m->faces.body[f]);
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, range, 2 * (PetscMPIInt)m->materials.n_groups, MPIU_INT, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether two bodies have faces of these groups that may come to touch and have no named joint. */
static PetscBool may_meet(const Model *m, const PetscInt *range, PetscInt a, PetscInt b)
{
  const PetscInt *ra = range + 2 * a, *rb = range + 2 * b;
  if (ra[1] < 0 || rb[1] < 0 || (!m->materials.upgradeable[a] && !m->materials.upgradeable[b]))
    return PETSC_FALSE;
  return (PetscBool)(PetscMax(ra[0], rb[0]) + PetscMax(ra[1], rb[1]) >
                     0); // they do not all belong to one body
}

PetscErrorCode LaterJoints(const Scene *scene, const Contacts *c, Model *m, char missing[MESSAGE_LENGTH])
{
  const PetscInt n = m->materials.n_groups;
  PetscInt *used, *range;
  PetscFunctionBeginUser;
  missing[0] = '\0';
  if (m->materials.later_joint || scene->joints[0].k_n > 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(n * n * scene->n_joints, &used, 2 * n, &range));
  PetscCall(PetscCalloc1(n * n, &m->materials.later_joint));
  PetscCall(rows_in_use(scene, m, c, used));
  PetscCall(bodies_in_reach(m, range));
  for (PetscInt i = 0; i < n * n; i++) {
    const char *a = m->materials.names[i / n], *b = m->materials.names[i % n];
    PetscInt *row = m->materials.later_joint + i;
    for (PetscInt j = 1; j < scene->n_joints; j++)
      if (used[i * scene->n_joints + j] && (!*row || JointIsWeaker(scene->joints + j, scene->joints + *row)))
        *row = j;
    if (*row || row_of_groups(scene, a, b) || !may_meet(m, range, i / n, i % n) || missing[0]) continue;
    PetscCall(PetscSNPrintf(missing, MESSAGE_LENGTH,
                            "blocks of groups %s and %s may come into contact, but no joint is for them: "
                            "expected the pair %s+%s or default",
                            a, b, a, b));
  }
  PetscCall(PetscFree2(used, range));
  if (missing[0]) PetscCall(PetscFree(m->materials.later_joint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rows without a contact */

/* Decides whether contacts of a row may come later: some stage finds contacts again, or places blocks. */
static PetscBool may_come_later(const Scene *scene)
{
  return (PetscBool)(SceneFindsAnew(scene) || SceneBuilds(scene));
}

/* Decides whether face f is in the face set of row j, or belongs to a group of its pair. */
static PetscBool is_of_row(const Scene *scene, const Model *m, PetscInt f, const bool *in_set, PetscInt j)
{
  const char *name = scene->joints[j].name, *plus = strchr(name, '+'), *group;
  if (!plus) return (PetscBool)in_set[f];
  group = m->materials.names[m->faces.group[f]];
  return (PetscBool)(!strcmp(plus + 1, group) || (strlen(group) == (size_t)(plus - name) &&
                                                  !strncmp(name, group, (size_t)(plus - name))));
}

/* Collective. Refuses row j, which has no contact; the message names the rows of the contacts where row j
   would count. */
static PetscErrorCode refuse_idle(const Scene *scene, const Model *m, const Contacts *c, PetscInt j,
                                  char *message)
{
  const PetscBool is_pair = (PetscBool)(strchr(scene->joints[j].name, '+') != NULL);
  char key[LABEL_LENGTH], taken[MESSAGE_LENGTH / 2] = "";
  PetscInt *takes;
  bool *in_set;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(scene->n_joints, &takes, m->faces.n, &in_set));
  for (PetscInt s = 0; s < m->mesh.n_face_sets; s++)
    for (PetscInt i = m->mesh.face_set_start[s]; i < m->mesh.face_set_start[s + 1]; i++)
      if (!strcmp(m->mesh.face_set_names[s], scene->joints[j].name)) in_set[m->mesh.face_set_faces[i]] = true;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || c->key[2 * i + 1] < 0) continue;
    const PetscInt f = FaceRow(m, c->key[2 * i]), g = FaceRow(m, c->key[2 * i + 1]);
    if (f < 0 || g < 0) continue;
    const PetscBool of_f = is_of_row(scene, m, f, in_set, j), of_g = is_of_row(scene, m, g, in_set, j);
    if (is_pair ? row_of_groups(scene, m->materials.names[m->faces.group[f]],
                                m->materials.names[m->faces.group[g]]) == j
                : of_f || of_g)
      takes[c->joint[i]] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, takes, (PetscMPIInt)scene->n_joints, MPIU_INT, MPI_MAX, m->comm));
  for (PetscInt k = 0; k < scene->n_joints; k++) {
    const size_t used = strlen(taken);
    if (takes[k] && used < sizeof taken - NAME_LENGTH)
      snprintf(taken + used, sizeof taken - used, "%s%s", used ? ", " : "", scene->joints[k].name);
  }
  snprintf(key, sizeof key, "joints.%s", scene->joints[j].name);
  if (taken[0])
    Complain(message, scene->file, scene->joints[j].line, key,
             "no contact has this row: all contacts %s have the rows %s: expected one contact at least: "
             "leave this row or those out",
             is_pair ? "between these groups" : "on its face set", taken);
  else
    Complain(message, scene->file, scene->joints[j].line, key,
             "no contact has this row: %s touch: expected one contact at least, or leave the row out",
             is_pair ? "these groups do not" : "on its face set no two bodies");
  PetscCall(PetscFree2(takes, in_set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Warns of face sets in joints that have no row of their own while other face sets have: their
   contacts take the default row. */
static PetscErrorCode warn_of_default(const Scene *scene, const Model *m, const Contacts *c)
{
  static PetscInt warned; // once, because advise.c sets up the same mesh many times
  PetscInt *of_default;
  bool *in_contact;
  char names[NAMES_LENGTH] = "";
  PetscFunctionBeginUser;
  if (scene->n_joints < 2 || !scene->joints[0].defined || AlreadyWarned(&warned))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(2 * m->mesh.n_face_sets, &of_default, m->faces.n + 1, &in_contact));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || c->key[2 * i + 1] < 0 || c->joint[i]) continue;
    for (int k = 0; k < 2; k++) {
      const PetscInt f = FaceRow(m, c->key[2 * i + k]);
      if (f >= 0) in_contact[f] = true;
    }
  }
  for (PetscInt s = 0; s < m->mesh.n_face_sets; s++)
    for (PetscInt i = m->mesh.face_set_start[s]; i < m->mesh.face_set_start[s + 1]; i++)
      of_default[2 * s] += in_contact[m->mesh.face_set_faces[i]], of_default[2 * s + 1]++;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, of_default, 2 * (PetscMPIInt)m->mesh.n_face_sets, MPIU_INT,
                             MPI_SUM, m->comm));
  for (PetscInt s = 0; s < m->mesh.n_face_sets && !m->rank; s++)
    if (of_default[2 * s] && 2 * of_default[2 * s] > of_default[2 * s + 1])
      AddName(m->mesh.face_set_names[s], names);
  if (names[0])
    Warn("no row of joints has the name of these face sets:%s; their contacts have the row default", names);
  PetscCall(PetscFree2(of_default, in_contact));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JointRowsCheck(const Scene *scene, const Model *m, const Contacts *c)
{
  const PetscBool later = may_come_later(scene);
  char message[MESSAGE_LENGTH] = "";
  PetscInt *used;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(scene->n_joints, &used));
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0) used[c->joint[i]] = 1;
  for (PetscInt f = 0; f < m->faces.n_local; f++) // a condensed body keeps the vertices of a row's face set
    if (m->faces.joint[f] >= 0 && (later || m->materials.condensed[m->faces.group[f]]))
      used[m->faces.joint[f]] = 1;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, used, (PetscMPIInt)scene->n_joints, MPIU_INT, MPI_MAX, m->comm));
  for (PetscInt j = 1; j < scene->n_joints && !message[0]; j++)
    if (!used[j] && !(later && strchr(scene->joints[j].name, '+')))
      PetscCall(refuse_idle(scene, m, c, j, message));
  PetscCall(PetscFree(used));
  PetscCall(CheckMessage(m->comm, message));
  PetscCall(warn_of_default(scene, m, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}
