/* flow_setup.c: prepares the flow of water in joints: finds the mesh entities of conditions, and refuses
   bad ones. */
#include "seepage/flow.h"

static PetscBool is_condition(LoadKind kind)
{
  return (PetscBool)(kind == LOAD_HEAD || kind == LOAD_DRAIN || kind == LOAD_CURTAIN || kind == LOAD_INFLOW);
}

PetscBool FlowActs(const Scene *scene, const Stage *stage, PetscInt *carrier)
{
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    if (!is_condition(scene->loads[stage->loads[i]].kind)) continue;
    *carrier = stage->loads[i];
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool FlowEverActs(const Scene *scene)
{
  PetscInt carrier;
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (FlowActs(scene, scene->stages + s, &carrier)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Collective. Gathers the faces of a load and their vertices on all ranks. */
static PetscErrorCode find_target(const Model *m, const Load *load, FlowTarget *target)
{
  PetscInt *faces, *vertices;
  PetscFunctionBeginUser;
  if (!load->target[0] || load->kind == LOAD_CURTAIN) PetscFunctionReturn(PETSC_SUCCESS);
  const PetscInt set = NameRow(m->mesh.n_face_sets, m->mesh.face_set_names, load->target);
  PetscCheck(set >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "no set of faces has the name '%s'", load->target);
  const PetscInt from = m->mesh.face_set_start[set], n = m->mesh.face_set_start[set + 1] - from;
  PetscCall(PetscMalloc2(n, &faces, 2 * n, &vertices));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt face = m->mesh.face_set_faces[from + i];
    faces[i] = m->faces.gid[face];
    for (int k = 0; k < 2; k++) vertices[2 * i + k] = m->mesh.vertex_gid[m->faces.vertex[2 * face + k]];
  }
  PetscCall(GatherToAll(m->comm, n, sizeof(PetscInt), faces, &target->n_faces, (void **)&target->faces));
  PetscCall(GatherToAll(m->comm, 2 * n, sizeof(PetscInt), vertices, &target->n_vertices,
                        (void **)&target->vertices));
  PetscCall(PetscSortRemoveDupsInt(&target->n_faces, target->faces));
  PetscCall(PetscSortRemoveDupsInt(&target->n_vertices, target->vertices));
  PetscCall(PetscFree2(faces, vertices));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a joint whose aperture is not less than the length of its longest contact. */
static void check_apertures(const Stage *stage, const FlowNetwork *net, PetscInt n_joints,
                            char message[MESSAGE_LENGTH])
{
  for (const Joint *joint = stage->joints; joint < stage->joints + n_joints && !message[0]; joint++) {
    const PetscBool closed = (PetscBool)(joint->aperture_residual > joint->aperture);
    const PetscReal widest = closed ? joint->aperture_residual : joint->aperture;
    PetscReal longest = -1.;
    for (PetscInt i = 0; i < net->n_rows; i++)
      if (stage->joints + net->row[i].joint == joint) longest = PetscMax(longest, net->row[i].length);
    if (longest >= 0. && widest >= longest)
      snprintf(message, MESSAGE_LENGTH,
               ":%d: joints.%s.%s: %g: expected less than the length of its contacts, %g [m]", joint->line,
               joint->name, closed ? "aperture_residual" : "aperture", (double)widest, (double)longest);
  }
}

/* Refuses an uplift on a joint in which water flows, and a head on faces inside a joint, where only faces
   at the end of a joint are meant. */
static void check_faces(const TermView *v, const Flow *flow, const Stage *stage, const FlowNetwork *net,
                        char message[MESSAGE_LENGTH])
{
  for (PetscInt i = 0; i < 2 * net->n_rows * stage->n_loads && !message[0]; i++) {
    const PetscInt l = stage->loads[i % stage->n_loads];
    const Load *load = v->scene->loads + l;
    const FlowRow *row = net->row + i / stage->n_loads / 2;
    const int side = i / stage->n_loads % 2;
    const PetscBool whole = (PetscBool)(PetscAbsReal(row->t[side][1] - row->t[side][0]) > 1. - 1e-6);
    PetscInt at;
    if (load->kind != LOAD_UPLIFT && load->kind != LOAD_HEAD && load->kind != LOAD_INFLOW) continue;
    PetscCallAbort(PETSC_COMM_SELF,
                   PetscFindInt(row->key[side], flow->target[l].n_faces, flow->target[l].faces, &at));
    if (at < 0) continue;
    const char *joint = stage->joints[row->joint].name;
    if (load->kind == LOAD_UPLIFT)
      snprintf(message, MESSAGE_LENGTH,
               ":%d: loads.%s.faces: water flows in the joint '%s' and presses on '%s' too: expected "
               "one of them",
               load->line, load->name, joint, load->target);
    else if (whole)
      snprintf(message, MESSAGE_LENGTH,
               ":%d: loads.%s.faces: a face of '%s' lies in the joint '%s': expected faces where "
               "joints end",
               load->line, load->name, load->target, joint);
  }
}

/* Decides whether two stages have the same conditions. */
static PetscBool same_conditions(const Scene *scene, const Stage *a, const Stage *b)
{
  PetscInt n = 0;
  for (PetscInt i = 0; i < a->n_loads; i++) {
    if (!is_condition(scene->loads[a->loads[i]].kind)) continue;
    PetscInt j = 0;
    while (j < b->n_loads && b->loads[j] != a->loads[i]) j++;
    if (j == b->n_loads) return PETSC_FALSE;
    n++;
  }
  for (PetscInt j = 0; j < b->n_loads; j++) n -= is_condition(scene->loads[b->loads[j]].kind);
  return (PetscBool)(n == 0);
}

/* Refuses contradicting or missing conditions of a stage. */
static void check_conditions(const Scene *scene, const Stage *stage, char message[MESSAGE_LENGTH])
{
  const Stage *before = StageBefore(scene, stage);
  PetscInt carrier, outlets = 0;
  if (message[0] || !FlowActs(scene, stage, &carrier)) return;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const Load *load = scene->loads + stage->loads[i];
    outlets += load->kind == LOAD_HEAD || (load->kind == LOAD_DRAIN && load->flow.conductance > 0.);
  }
  if (scene->gravity == 0.)
    snprintf(message, MESSAGE_LENGTH,
             ": gravity: 0 is out of range: must be > 0 [m/s2] where water flows in joints");
  else if (!outlets)
    snprintf(message, MESSAGE_LENGTH,
             ":%d: stages.%s.loads: water flows in joints (loads.%s): expected a head or an open drain, "
             "which says how high",
             stage->line, stage->name, scene->loads[carrier].name);
  else if (StageInTime(stage) && before && FlowActs(scene, before, &carrier) &&
           !same_conditions(scene, before, stage))
    snprintf(message, MESSAGE_LENGTH,
             ":%d: stages.%s.loads: a dynamic stage keeps the water in joints of the stage before: expected "
             "the same "
             "heads, drains, curtains and inflows",
             stage->line, stage->name);
}

PetscReal FlowReach(const Scene *scene, const Model *m)
{
  const PetscReal touching = 1e-9 * m->mesh.diameter;
  return scene->contact_relative ? touching : PetscMax(touching, scene->contact_tolerance);
}

/* Warns of faces that are apart in the mesh: by rounding, or across a layer thinner than
   contact.tolerance. They leave water more room than the aperture of their joint. Rank 0, once a run. */
static void warn_gaps(const TermView *v, const Stage *stage, const FlowNetwork *net)
{
  static PetscInt runs;
  const PetscBool warned = AlreadyWarned(&runs);
  const PetscReal much = 0.1; // of the aperture
  for (PetscInt j = 0; j < v->scene->n_joints && !warned && !v->m->rank; j++) {
    PetscReal most = 0.;
    const FlowRow *worst = NULL;
    for (const FlowRow *row = net->row; row < net->row + net->n_rows; row++)
      for (int k = 0; k < 2; k++)
        if (row->joint == j && row->opening[k] > most) most = row->opening[k], worst = row;
    if (!worst || most <= much * stage->joints[j].aperture) continue;
    Warn("joints.%s: near (%.6g, %.6g) m faces are %.3g m apart in the mesh, which adds to "
         "aperture %g m: bring them together, or lower contact.tolerance, %g m",
         stage->joints[j].name, (double)worst->x[0][0], (double)worst->x[0][1], (double)most,
         (double)stage->joints[j].aperture, (double)v->scene->contact_tolerance);
  }
}

/* Collective. Checks the network of a stage with the contacts of the start. Joints that let water in after
   failure count as open. */
static PetscErrorCode check_network(const TermView *v, const Flow *flow, const Stage *stage,
                                    char message[MESSAGE_LENGTH])
{
  FlowNetwork net = {.step = stage->kind == STAGE_TRANSIENT ? 1. : 0.};
  PetscBool *cut_off;
  PetscInt carrier;
  char conflict[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (message[0] || !FlowActs(v->scene, stage, &carrier)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowRowsGather(v->m, v->contacts, stage->joints, v->state->u + 3 * v->m->rigid.n, &net.n_rows,
                           &net.row));
  for (PetscInt i = 0; i < net.n_rows; i++) net.row[i].shut = 0;
  warn_gaps(v, stage, &net);
  check_apertures(stage, &net, v->scene->n_joints, message);
  check_faces(v, flow, stage, &net, message);
  if (!net.n_rows)
    snprintf(message, MESSAGE_LENGTH,
             ":%d: stages.%s.loads: water flows in joints (loads.%s), but no contact lets it in: "
             "expected a joint with an aperture",
             stage->line, stage->name, v->scene->loads[carrier].name);
  else if (!message[0]) {
    PetscCall(
        FlowNetworkBuild(v->scene, stage, flow->target, FlowReach(v->scene, v->m), &net, message, conflict));
    if (!message[0] && stage->kind != STAGE_TRANSIENT)
      PetscCall(PetscStrncpy(message, conflict, MESSAGE_LENGTH));
    PetscCall(PetscCalloc1(net.n_nodes, &cut_off));
    PetscCall(FlowFindCutOff(&net, cut_off, message));
    PetscCall(PetscFree(cut_off));
  }
  PetscCall(FlowNetworkDestroy(&net));
  PetscCall(PetscFree(net.row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowRefuse(const TermView *v, const Stage *stage, const char *message)
{
  char line[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (message[0])
    snprintf(line, sizeof(line), "%.200s%.700s (stage %s)", v->scene->file, message, stage->name);
  PetscCall(CheckMessage(v->m->comm, line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the end of its joint from which the distance of a drain counts. */
static PetscErrorCode find_heel(const TermView *v, PetscInt load, FlowTarget *target)
{
  char message[MESSAGE_LENGTH] = "";
  PetscReal ends[4];
  PetscFunctionBeginUser;
  if (v->scene->loads[load].kind != LOAD_DRAIN || !v->scene->loads[load].target[0])
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(JointEnds(v->m, v->scene->loads[load].target, ends));
  PetscCall(HeelOf(v->scene, v->m, load, ends, &target->from_end, message));
  PetscCall(CheckMessage(v->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowCreate(const TermView *v, void **memory)
{
  const Scene *scene = v->scene;
  Flow *flow;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&flow));
  *memory = flow;
  flow->sums.within = 1.;
  PetscCall(PetscCalloc1(scene->n_loads, &flow->target));
  for (PetscInt l = 0; l < scene->n_loads; l++)
    if (is_condition(scene->loads[l].kind) || scene->loads[l].kind == LOAD_UPLIFT) {
      PetscCall(find_target(v->m, scene->loads + l, flow->target + l));
      PetscCall(find_heel(v, l, flow->target + l));
    }
  for (PetscInt s = 0; s < scene->n_stages; s++) {
    const Stage *stage = scene->stages + s;
    char message[MESSAGE_LENGTH] = "";
    check_conditions(scene, stage, message);
    PetscCall(check_network(v, flow, stage, message));
    PetscCall(FlowRefuse(v, stage, message));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowDestroy(const Scene *scene, void **memory)
{
  Flow *flow = *memory;
  PetscFunctionBeginUser;
  if (!flow) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    PetscCall(PetscFree(flow->target[l].faces));
    PetscCall(PetscFree(flow->target[l].vertices));
  }
  PetscCall(PetscFree(flow->target));
  PetscCall(FlowNetworkDestroy(&flow->net));
  PetscCall(FlowSolutionDestroy(&flow->now));
  PetscCall(MixerReset(&flow->mixer));
  PetscCall(PetscFree(flow->net.row));
  PetscCall(PetscFree(flow->acting));
  PetscCall(PetscFree(flow->push));
  PetscCall(PetscFree(flow->reference));
  PetscCall(PetscFree(flow->past));
  PetscCall(PetscFree(flow->present));
  PetscCall(PetscFree(flow->row_stable));
  PetscCall(PetscFree(flow->acting_stable));
  PetscCall(PetscFree(flow->present_stable));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}
