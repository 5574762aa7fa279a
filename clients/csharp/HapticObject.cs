// Unity: the tracer with the physics of the scene. A HapticObject on each body that vibration runs through, HapticSources and
// HapticListeners on these or below them; with or without the tables of NAME.tracer.json. A unit is a metre.

using System.Collections.Generic;
using HapticTracer;
using UnityEngine;

namespace HapticTracing
{
    /// <summary>The tracer of the scene, made by the first component that asks. Objects of the file are found by their names.</summary>
    public static class HapticWorld
    {
        /// <summary>The tables, to be set before any component is enabled; without them objects are as their components say.</summary>
        public static TextAsset Tables;
        static Tracer tracer;
        static float stepped = -1;

        public static Tracer Tracer { get { return tracer ?? (tracer = Tables == null ? new Tracer() : Tracer.Read(Tables.text)); } }

        /// <summary>Unity's axes are left-handed: importers of glTF turn x round, and so do the tables' positions.</summary>
        public static Vector At(Vector3 v) { return new Vector(-v.x, v.y, v.z); }

        public static void Step()
        {
            if (stepped == Time.fixedTime) return;
            stepped = Time.fixedTime;
            Tracer.Step(Time.fixedDeltaTime);
        }

        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.SubsystemRegistration)]
        static void Forget()
        {
            tracer = null;
            stepped = -1;
        }
    }

    /// <summary>A body that vibration runs through, with a collider. The fields count where the tables do not name it.</summary>
    public sealed class HapticObject : MonoBehaviour
    {
        [Tooltip("A higher one passes on less"), Range(0, 1)] public float kappa = 0.1f;
        [Tooltip("A higher one passes on more, but fades faster"), Range(0, 1)] public float rho = 0.9f;
        [Tooltip("Its collisions sound")] public bool strikes = true;

        readonly Dictionary<HapticObject, Contact> touched = new Dictionary<HapticObject, Contact>();
        readonly List<ContactPoint> points = new List<ContactPoint>();
        public TracedObject Traced { get; private set; }

        void Awake()
        {
            Traced = HapticWorld.Tracer.Objects.Find(item => item.Name == name);
            if (Traced != null) return;
            var body = GetComponent<Rigidbody>();
            Traced = new TracedObject { Function = Function.Paper(kappa, rho, HapticWorld.Tracer.Lanes), Mass = body == null || body.isKinematic ? 0 : body.mass };
            HapticWorld.Tracer.Objects.Add(Traced);
        }

        void FixedUpdate()
        {
            Vector3 p = transform.position;
            Quaternion q = transform.rotation;
            Traced.Move(-p.x, p.y, p.z, q.w, q.x, -q.y, -q.z);
        }

        void OnCollisionEnter(Collision collision)
        {
            OnCollisionStay(collision);
            var other = Other(collision);
            if (other == null || !strikes || !other.strikes || !Tells(other)) return;
            var point = collision.GetContact(0);
            var speed = Vector3.Dot(collision.relativeVelocity, point.normal);
            HapticWorld.Tracer.Blow(Traced, other.Traced, HapticWorld.At(point.point), Tracer.Energy(Traced, other.Traced, speed));
        }

        void OnCollisionStay(Collision collision)
        {
            var other = Other(collision);
            Contact contact;
            if (other == null || !Tells(other)) return;
            if (!touched.TryGetValue(other, out contact)) touched[other] = contact = HapticWorld.Tracer.Touch(Traced, other.Traced);
            if (contact == null) return;
            Vector3 place = Vector3.zero, normal = Vector3.zero;
            collision.GetContacts(points);
            foreach (var point in points)
            {
                place += point.point / points.Count;
                normal += point.normal / points.Count;
            }
            contact.At = contact.OtherAt = HapticWorld.At(place);
            contact.Normal = HapticWorld.At(normal.normalized);
            contact.Force = collision.impulse.magnitude / Time.fixedDeltaTime;
        }

        void OnCollisionExit(Collision collision)
        {
            var other = Other(collision);
            if (other != null) Leave(other);
        }

        void OnDisable()
        {
            foreach (var other in new List<HapticObject>(touched.Keys)) Leave(other);
        }

        void OnDestroy() { if (Traced.Name == "") HapticWorld.Tracer.Remove(Traced); }

        void Leave(HapticObject other)
        {
            Contact contact;
            if (touched.TryGetValue(other, out contact) && contact != null) HapticWorld.Tracer.Part(contact);
            touched.Remove(other);
        }

        static HapticObject Other(Collision collision) { return collision.collider.GetComponentInParent<HapticObject>(); }

        /// <summary>Both are told of a collision; one of them passes it on.</summary>
        bool Tells(HapticObject other) { return GetInstanceID() < other.GetInstanceID(); }
    }
}
