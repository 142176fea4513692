"""The table of physics schemas: which attributes are read, and what follows where one is not.

`*` stands for the instance name of a schema that is applied several times, and for any end of a name in `UNREAD`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

_JOINT = (
    "physics:body0 physics:body1 physics:localPos0 physics:localPos1 physics:localRot0 physics:localRot1 "
    "physics:excludeFromArticulation physics:jointEnabled physics:collisionEnabled "
    "physics:breakForce physics:breakTorque"
)

# Type or applied schema -> attributes and relationships that are read.
READ: dict[str, str] = {
    # UsdPhysics
    "PhysicsScene": "physics:gravityDirection physics:gravityMagnitude",
    "PhysicsRigidBodyAPI": "physics:rigidBodyEnabled physics:kinematicEnabled physics:simulationOwner "
    "physics:velocity physics:angularVelocity physics:startsAsleep",
    "PhysicsMassAPI": "physics:mass physics:density physics:centerOfMass physics:diagonalInertia physics:principalAxes",
    "PhysicsCollisionAPI": "physics:collisionEnabled physics:simulationOwner",
    "PhysicsMeshCollisionAPI": "physics:approximation",
    "PhysicsMaterialAPI": "physics:dynamicFriction physics:staticFriction physics:restitution physics:density",
    "PhysicsCollisionGroup": "physics:filteredGroups physics:invertFilteredGroups physics:mergeGroup "
    "collection:colliders collection:colliders:includes collection:colliders:excludes "
    "collection:colliders:expansionRule collection:colliders:includeRoot "
    "collection:colliders:membershipExpression collection:colliders:mode",
    "PhysicsFilteredPairsAPI": "physics:filteredPairs",
    "PhysicsArticulationRootAPI": "",
    "PhysicsJoint": _JOINT,
    "PhysicsFixedJoint": _JOINT,
    "PhysicsRevoluteJoint": f"{_JOINT} physics:axis physics:lowerLimit physics:upperLimit",
    "PhysicsPrismaticJoint": f"{_JOINT} physics:axis physics:lowerLimit physics:upperLimit",
    "PhysicsSphericalJoint": f"{_JOINT} physics:axis physics:coneAngle0Limit physics:coneAngle1Limit",
    "PhysicsDistanceJoint": f"{_JOINT} physics:minDistance physics:maxDistance",
    "PhysicsDriveAPI": "drive:*:physics:targetPosition drive:*:physics:targetVelocity drive:*:physics:stiffness "
    "drive:*:physics:damping drive:*:physics:maxForce drive:*:physics:type",
    "PhysicsLimitAPI": "limit:*:physics:low limit:*:physics:high",
    "PhysicsJointStateAPI": "state:*:physics:position state:*:physics:velocity",
    # PhysxSchema
    "PhysxSceneAPI": "physxScene:timeStepsPerSecond physxScene:invertCollisionGroupFilter physxScene:bounceThreshold",
    "PhysxRigidBodyAPI": "physxRigidBody:disableGravity physxRigidBody:linearDamping physxRigidBody:angularDamping "
    "physxRigidBody:maxLinearVelocity physxRigidBody:maxAngularVelocity physxRigidBody:maxDepenetrationVelocity "
    "physxRigidBody:sleepThreshold physxRigidBody:lockedPosAxis physxRigidBody:lockedRotAxis physxRigidBody:enableCCD",
    "PhysxCollisionAPI": "physxCollision:contactOffset physxCollision:restOffset",
    "PhysxForceAPI": "physxForce:force physxForce:torque physxForce:mode physxForce:forceEnabled "
    "physxForce:worldFrameEnabled",
    "PhysxSurfaceVelocityAPI": "physxSurfaceVelocity:surfaceVelocity physxSurfaceVelocity:surfaceAngularVelocity "
    "physxSurfaceVelocity:surfaceVelocityEnabled physxSurfaceVelocity:surfaceVelocityLocalSpace",
    "PhysxContactReportAPI": "physxContactReport:threshold physxContactReport:reportPairs",
    "PhysxTriggerAPI": "",
    "PhysxTriggerStateAPI": "physxTrigger:triggeredCollisions",
    "PhysxMaterialAPI": "physxMaterial:frictionCombineMode physxMaterial:restitutionCombineMode",
    "PhysxConvexDecompositionCollisionAPI": "physxConvexDecompositionCollision:maxConvexHulls "
    "physxConvexDecompositionCollision:hullVertexLimit physxConvexDecompositionCollision:errorPercentage",
    # These hold settings only: applying them changes nothing, and each setting is among those of `UNREAD`.
    "PhysxConvexHullCollisionAPI": "",
    "PhysxSphereFillCollisionAPI": "",
    "PhysxSDFMeshCollisionAPI": "",
    "PhysxTriangleMeshCollisionAPI": "",
    "PhysxTriangleMeshSimplificationCollisionAPI": "",
    "PhysxMimicJointAPI": "physxMimicJoint:*:referenceJoint physxMimicJoint:*:gearing physxMimicJoint:*:offset",
    "PhysxPhysicsDistanceJointAPI": "physxPhysicsDistanceJoint:springEnabled "
    "physxPhysicsDistanceJoint:springStiffness physxPhysicsDistanceJoint:springDamping",
    "PhysxPhysicsGearJoint": f"{_JOINT} physics:hinge0 physics:hinge1 physics:gearRatio",
    "PhysxPhysicsRackAndPinionJoint": f"{_JOINT} physics:hinge physics:prismatic physics:ratio",
    "PhysxJointAPI": "physxJoint:armature physxJoint:maxJointVelocity physxJoint:jointFriction",
    "PhysxJointAxisAPI": "physxJointAxis:*:armature physxJointAxis:*:maxJointVelocity "
    "physxJointAxis:*:viscousFrictionCoefficient physxJointAxis:*:staticFrictionEffort",
    "PhysxLimitAPI": "",
    "PhysxArticulationAPI": "physxArticulation:enabledSelfCollisions physxArticulation:articulationEnabled",
    "PhysxCookedDataAPI": "",
}


@dataclass(frozen=True)
class Unread:
    """Schemas and attributes that have no effect, and what follows from that."""

    names: str
    follows: str


# The first row with a fitting name counts.
UNREAD: tuple[Unread, ...] = (
    # what is not simulated at all
    Unread(
        "PhysxDeformable* PhysxBaseDeformable* PhysxSurfaceDeformable* PhysxAutoDeformable* PhysxAutoAttachment* "
        "PhysxPhysicsAttachment PhysxTetrahedralMesh PhysxVolumeDeformable* OmniPhysics* physxDeformable* "
        "physxAutoDeformable* physxAutoAttachment:* omniphysics:* deformablePose:*",
        "deformable bodies are not simulated: they stay as they are drawn, and nothing collides with them. Make them "
        "rigid bodies, or bake their motion",
    ),
    Unread(
        "PhysxParticle* PhysxPBDMaterialAPI PhysxDiffuseParticlesAPI PhysxAutoParticleClothAPI PhysxIsosurfaceAPI "
        "physxParticle* physxPBDMaterial:* physxDiffuseParticles:* physxAutoParticleCloth:* physxIsosurface:*",
        "particles, fluids and cloth are not simulated: they stay as they are drawn. Bake their motion",
    ),
    Unread(
        "PhysxVehicle* physxVehicle*",
        "vehicles are not simulated: their bodies fall and roll like any others, without suspension, drive and "
        "steering. Move a kinematic body instead",
    ),
    Unread(
        "PhysxCamera* physxCamera:* physxFollow* physxDroneCamera:*",
        "cameras do not follow vehicles. Animate them",
    ),
    Unread(
        "PhysxCharacterControllerAPI physxCharacterController:*",
        "character controllers are not simulated. Make the character a kinematic body and move it",
    ),
    Unread(
        "PhysxPhysicsInstancer PhysxPhysicsJointInstancer physics:body0Indices physics:body0s physics:body1Indices "
        "physics:body1s physics:localPos0s physics:localPos1s physics:localRot0s physics:localRot1s "
        "physics:protoIndices physics:prototypes",
        "instanced joints are not simulated. Make a joint prim for each",
    ),
    Unread(
        "Mjc* mjc:* Newton* newton:*",
        "schemas of MuJoCo and Newton are not read: their actuators, equalities and settings have no effect. Author "
        "UsdPhysics.DriveAPI, PhysxMimicJointAPI and joints instead",
    ),
    # joints
    Unread("PhysxTendon* physxTendon:*", "tendons are not simulated: they pull no joint"),
    Unread(
        "physxMimicJoint:*",
        "joints that mimic others follow their reference joint, of one axis, without compliance",
    ),
    Unread(
        "physxLimit:*",
        "limits of joints are hard and do not bounce: softness and restitution of a limit have no effect",
    ),
    Unread("physxJoint:* physxJointAxis:*", "joints rub with their static friction, also while they move"),
    Unread(
        "PhysxDrivePerformanceEnvelopeAPI physxDrivePerformanceEnvelope:*",
        "the force of a drive does not depend on its speed: its maximum force alone limits it",
    ),
    Unread(
        "PhysxArticulationForceSensorAPI physxArticulationForceSensor:*",
        "there are no sensors of forces in joints: call get_measured_joint_forces of an Articulation",
    ),
    Unread(
        "physxArticulation:*",
        "all articulations are simulated with the same solver, so its settings for one have no effect",
    ),
    # rigid bodies
    Unread(
        "physxRigidBody:enableSpeculativeCCD physxScene:enableCCD",
        "contacts are found within the contact offset of where bodies are 120 times a second, near triangle meshes up "
        "to 480 times: what travels farther than that offset and half of its thickness meanwhile may pass through a "
        "wall. Set physxRigidBody:enableCCD on the body, which finds what is on its way, or take more steps per second",
    ),
    Unread(
        "physxRigidBody:solverPositionIterationCount physxRigidBody:solverVelocityIterationCount "
        "physxScene:minPositionIterationCount physxScene:maxPositionIterationCount "
        "physxScene:minVelocityIterationCount physxScene:maxVelocityIterationCount physxScene:solverType "
        "physxScene:enableExternalForcesEveryIteration physxScene:solveArticulationContactLast",
        "every scene is solved with the same solver, two substeps of 24 iterations each at 60 steps per second; for "
        "more precision take more steps per second",
    ),
    Unread(
        "physxRigidBody:stabilizationThreshold physxScene:enableStabilization physxScene:disableSleeping",
        "bodies on a support are held at rest by physxRigidBody:sleepThreshold alone; 0 keeps one moving",
    ),
    Unread("physxRigidBody:enableGyroscopicForces", "gyroscopic torque always acts"),
    Unread("physxRigidBody:retainAccelerations", "forces act during one step, and are not retained"),
    Unread(
        "physxRigidBody:maxContactImpulse physxRigidBody:solveContact physxRigidBody:cfmScale "
        "physxRigidBody:contactSlopCoefficient physxScene:maxBiasCoefficient",
        "contacts are solved, unlimited and stiff. Disable the collider of a body that shall not be pushed",
    ),
    # colliders
    Unread(
        "physxTrigger:enterScriptType physxTrigger:leaveScriptType physxTrigger:onEnterScript "
        "physxTrigger:onLeaveScript",
        "files of a stage are not run: subscribe to triggers in the script instead",
    ),
    Unread(
        "PhysxSplinesSurfaceVelocityAPI physxSplinesSurfaceVelocity:*",
        "surfaces do not move along curves. Give straight parts a PhysxSurfaceVelocityAPI each",
    ),
    Unread(
        "physxCollision:torsionalPatchRadius physxCollision:minTorsionalPatchRadius",
        "contact points have no torsional friction: what turns on one point keeps turning",
    ),
    Unread(
        "physxConvexHullCollision:*",
        "convex hulls have at most 64 vertices and are at least a thousandth of their size thick",
    ),
    Unread(
        "physxConvexDecompositionCollision:minThickness physxConvexDecompositionCollision:shrinkWrap "
        "physxConvexDecompositionCollision:voxelResolution physxSphereFillCollision:*",
        "convex parts of meshes depend on how many there may be, their vertices and the error alone, and meshes do not "
        "become spheres",
    ),
    Unread(
        "physxSDFMeshCollision:* physxTriangleMeshCollision:* physxTriangleMeshSimplificationCollision:*",
        "meshes of static colliders and kinematic bodies collide with all their triangles, those of other bodies as "
        "convex hulls or parts; how finely PhysX would represent them does not matter",
    ),
    Unread(
        "PhysxMeshMergeCollisionAPI collection:collisionmeshes*",
        "meshes are not merged: those with CollisionAPI of their own collide. Apply it to each",
    ),
    Unread("physxCookedData:*", "cooked collision data is not used: shapes are made from the meshes"),
    Unread(
        "physxMaterial:compliantContactStiffness physxMaterial:compliantContactDamping "
        "physxMaterial:compliantContactAccelerationSpring physxMaterial:dampingCombineMode",
        "contacts are stiff, not springs",
    ),
    # scenes
    Unread(
        "PhysxSceneQuasistaticAPI physxSceneQuasistatic:* collection:quasistaticactors*",
        "everything is simulated dynamically",
    ),
    Unread(
        "physxScene:frictionType physxScene:frictionOffsetThreshold physxScene:frictionCorrelationDistance",
        "friction acts at every contact point",
    ),
    Unread(
        "physxScene:reportKinematicKinematicPairs physxScene:reportKinematicStaticPairs "
        "physxScene:enableResidualReporting",
        "pairs that cannot push each other, and residuals, are not reported",
    ),
    Unread("physxScene:enableSceneQuerySupport physxScene:updateType", "queries and steps are available in any case"),
    Unread(
        "physxScene:gpu* physxScene:broadphaseType physxScene:collisionSystem physxScene:enableGPUDynamics "
        "physxScene:enableEnhancedDeterminism",
        "how PhysX computes, and with which memory, does not matter here: buffers grow as needed, and a run repeats "
        "bit for bit; --device chooses the processor",
    ),
)
# Values of unread attributes that ask for what is done anyway.
UNREAD_BUT_MET: dict[str, tuple[object, ...]] = {
    "physxScene:enableGPUDynamics": (False,),
    "physxScene:broadphaseType": ("MBP", "SAP"),  # those of the CPU
    "physxScene:enableCCD": (True,),  # it only allows what physxRigidBody:enableCCD asks for
}
_UNKNOWN = Unread("", "this is no schema or attribute that usdsdg knows, so it has no effect")

_NAMESPACES = ("physics:", "physx", "omniphysics:", "drive:", "limit:", "state:", "deformablePose:", "mjc:", "newton:")
_COLLECTIONS = ("collection:collisionmeshes", "collection:quasistaticactors")


def is_physics_attribute(name: str) -> bool:
    """Return whether an attribute or relationship of this name belongs to a physics schema."""
    if name.startswith(("drive:", "limit:", "state:", "deformablePose:")):
        return ":physics:" in name or ":omniphysics:" in name
    return name.startswith((*_NAMESPACES, *_COLLECTIONS))


def is_physics_schema(name: str) -> bool:
    """Return whether a type or applied schema of this name belongs to physics."""
    return name.startswith(("Physics", "Physx", "OmniPhysics", "Mjc", "Newton"))


@cache
def unread_attribute(name: str) -> Unread | None:
    """Return what follows from an authored attribute; None where it is read."""
    head, _, rest = name.partition(":")
    instance, _, last = rest.partition(":")
    general = f"{head}:*:{last}" if instance and last else name
    return None if name in _READ_ATTRIBUTES or general in _READ_ATTRIBUTES else _row(name)


@cache
def unread_schema(name: str) -> Unread | None:
    """Return what follows from a type or applied schema (without its instance name); None where it is read."""
    return None if name in READ else _row(name)


def _row(name: str) -> Unread:
    for row in UNREAD:
        for pattern in row.names.split():
            if name == pattern or (pattern.endswith("*") and name.startswith(pattern[:-1])):
                return row
    return _UNKNOWN


_READ_ATTRIBUTES = frozenset(name for names in READ.values() for name in names.split())
