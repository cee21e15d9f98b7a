"""What the NetworkPolicies of a deployment let through."""


def allowed(objects, way):
    """Component of a policy's own pods, component of their peers, and port, of every rule of a way in or out."""
    policies = [each["spec"] for each in objects if each["kind"] == "NetworkPolicy"]
    return {
        (component, peer, port)
        for policy in policies
        for component in _components_of(policy["podSelector"])
        for rule in policy.get(way, [])
        for selector in rule.get("from", rule.get("to", []))
        for peer in _components_of(selector.get("podSelector", {}))
        for ports in rule["ports"]
        for port in range(ports["port"], ports.get("endPort", ports["port"]) + 1)
    }


def _components_of(selector):
    """Values of the component's label that a selector takes."""
    wanted = selector.get("matchLabels", {}).get("app.kubernetes.io/component")
    values = [value for each in selector.get("matchExpressions", []) for value in each["values"]]
    return [wanted] if wanted else values
