"""`isaacsim.replicator.behavior.global_variables`: names that behaviors share."""

EXTENSION_NAME = "isaacsim.replicator.behavior"  # prefix of the behaviors' events
EXPOSED_ATTR_NS = "exposedVar"  # exposedVar:<behavior>:<variable>
SCOPE_NAME = "/Behaviors"  # parent of the prims that behaviors create
EXPOSED_VARS_CHANGED_EVENT = f"{EXTENSION_NAME}.EXPOSED_VARS_CHANGED"
